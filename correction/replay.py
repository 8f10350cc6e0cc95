"""MuJoCo plays a recovered motion through a rig: what the IMUs would read, springs and all."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline

from imubench.arrays import Array
from imubench.diagnosis.config.correction import REPLAY
from imubench.diagnosis.evidence import Played
from imubench.diagnosis.problem.bspline import DEGREE
from imubench.diagnosis.problem.rig_kinematics import attitude
from imubench.effects import traits_of
from imubench.errors import InputError
from imubench.jets import Jet
from imubench.sim.joints import Play
from imubench.sim.motion import Trajectory
from imubench.sim.play import play
from imubench.sim.rigs import Rig
from imubench.sim.signals import check_within
from imubench.truth import Truth


class SplineMotion:
    """A recovered motion between its rows: quintic splines through them, time counted from `start` s.

    Where the motion has a force instead of a position, the acceleration R f + g is integrated twice, from rest
    on average: the place is then arbitrary, and free to drift. It is defined from the first to the last row, give or
    take one, and raises `InputError` elsewhere.
    """

    def __init__(self, motion: Played, start: float, gravity: float) -> None:
        time = motion.time - start
        row = float(np.median(np.diff(time)))
        self.start, self.end = float(time[0]) - row, float(time[-1]) + row  # s
        self.turns = make_interp_spline(time, motion.quaternion1, DEGREE)
        angle = np.zeros(time.size) if motion.hinge_angle is None else motion.hinge_angle
        self.angle = make_interp_spline(time, angle, DEGREE)
        if motion.force is None:
            self.place = make_interp_spline(time, motion.position, DEGREE)
            return
        fine = np.linspace(time[0], time[-1], REPLAY.steps_per_knot * (time.size - 1) + 1)
        turn, _, _ = attitude(*(Jet(self.turns(fine, order)) for order in range(3)))
        force = Jet(make_interp_spline(time, motion.force, DEGREE)(fine))
        pushed = turn.forth(force).value - [0.0, 0.0, gravity]
        if not np.isfinite(pushed).all():
            raise InputError("motion: expected quaternions and forces of a usual size, got ones that overflow")
        accel = make_interp_spline(fine, pushed, DEGREE)
        away = accel.antiderivative(2)
        mean = (away(fine[-1]) - away(fine[0])) / (fine[-1] - fine[0])
        self.place = make_interp_spline(fine, away(fine) - fine[:, None] * mean, DEGREE)

    def __call__(self, time: Array) -> Trajectory:
        """Return the trajectory at `time` (n,) s; `InputError` beyond the rows."""
        check_within(time, self.start, self.end)
        q = self.turns(time)
        _, rate, accel = attitude(*(Jet(self.turns(time, order)) for order in range(3)))
        place, speed, acceleration = (self.place(time, order) for order in range(3))
        angle, angle_rate, angle_acceleration = (self.angle(time, order) for order in range(3))
        return Trajectory(
            time,
            place,
            speed,
            acceleration,
            q / np.linalg.norm(q, axis=1, keepdims=True),
            rate.value,
            accel.value,
            angle,
            angle_rate,
            angle_acceleration,
        )


class GivenSignal:
    """A signal between its rows: a quintic spline through them, from the first to the last, give or take one."""

    def __init__(self, time: Array, values: Array) -> None:
        row = float(np.median(np.diff(time)))
        self.start, self.end = float(time[0]) - row, float(time[-1]) + row  # s
        self.spline = make_interp_spline(time, values, DEGREE)

    def __call__(self, time: Array) -> tuple[Array, Array, Array]:
        """Return value and derivatives at `time` (n,) s; `InputError` beyond the rows."""
        check_within(time, self.start, self.end)
        first, second, third = (np.asarray(self.spline(time, order)) for order in range(3))
        return first, second, third


def truth_of_motion(rig: Rig, motion: Played, start: float, seconds: float, rate: float) -> Truth:
    """Return MuJoCo's truth of a recovered motion on a rig, dense enough for IMUs of `rate` Hz."""
    dense = dense_rows(rate)
    rig = with_play_of_motion(rig, motion, start)
    return play(rig, SplineMotion(motion, start, rig.gravity), seconds + REPLAY.end_rows / dense, dense)


def dense_rows(rate: float) -> float:
    """Return the rows a second of a truth for IMUs of `rate` Hz."""
    return rate * max(1, int(np.ceil(REPLAY.least_rate_hz / rate)))


def play_of_motion(motion: Played, play: Play) -> Array | None:
    """Return how a limb turned in its play, (2, n) rad about e and beside it (`sim.joints`), at a motion's rows.

    None where the motion does not tell, or the play is on springs: that follows by its law. What falls from side to
    side between stops that nobody measured has no law to be foretold by.
    """
    if play.frequency:
        return None
    if motion.play is not None:
        return motion.play
    for f in (f for f in motion.fitted if traits_of(f.effect).loosens and f.signals):
        (rotation,) = (signal.T for signal in f.signals.values())
        if len(rotation) == 1:
            return np.stack([rotation[0], 0 * rotation[0]])
        return np.asarray(np.stack([play.axis, play.beside])[:, [0, 2]] @ rotation)
    return None


def with_play_of_motion(rig: Rig, motion: Played, start: float) -> Rig:
    """Return a rig whose play does what a motion says of it, if it says anything."""
    if rig.loose is None or (told := play_of_motion(motion, rig.loose)) is None:
        return rig
    path = GivenSignal(motion.time - start, told[0]), GivenSignal(motion.time - start, told[1])
    return replace(rig, play=replace(rig.loose, path=path))
