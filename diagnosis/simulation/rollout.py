"""A free swing by forces alone: MuJoCo integrates a rig from a state at the window's start.

Weight, the joint's torques and the declared body are the rig's; nothing is prescribed. Sensors weigh nothing here:
the declared body is with them. A hinge on a base that stands still has the state (q, q'), a limb on a ball joint
(R, w), R segment -> world, w in segment axes.

Dry friction turns over in the moment in which the joint does: of a hinge by steps that end there (`sim.dry_hinge`), on
a ball joint by steps that have it exact (`sim.ball`). MuJoCo's own friction turns over a step before the joint does: a
roll-out is off by as much as the step is long (by 3e-3 rad after 8 s in steps of 1 ms), and no smooth function of its
start and of the friction.

What is measured shows a state to its noise, and a swing of many periods shows what is wrong with that at its end. So
the state is refined by Gauss and Newton until the first second of the roll-out fits the samples best, a period of a
limb of 25 cm, in which hundreds of samples tell two or six numbers, and friction takes off next to nothing; from there
until all of the window does. A swing of 2 rad whose amplitude is 1e-4 off is late by 0.4 ms after ten seconds, and a
gyroscope sees 0.01 rad/s of that. Where a swing is to be foretold its start is that of the first second.

What is left unknown of the state grows. With J(t) the derivatives of what the sensors read, over their noise, by the
state, and P = (J' J)^-1 from the first second, the roll-out is uncertain by sqrt(J(t) P J(t)') times the noise. A hinge
has one degree of freedom and is never chaotic. A limb on a ball joint may be, without friction: there it grows tenfold
in two seconds, and beyond its `horizon` no model foretells anything. The roll-out then starts anew.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.simulation import ROLL_OUT
from imubench.diagnosis.config.solve import ALGEBRA, SOLVER
from imubench.diagnosis.evidence import Played, Swing
from imubench.errors import InputError
from imubench.sim.dry_hinge import swing_dry_hinge
from imubench.sim.rigs import Mount, Rig
from imubench.sim.swing import Start, Torque, swing_many

Misfit = Callable[[Swing], tuple[Array, Array]]
"""Takes a window; returns the times (n,) s of all samples in it, and simulated minus measured over the noise (n,)."""


def can_swing(rig: Rig) -> bool:
    """Return whether gravity and torques alone move a rig: on a base or a pivot that stands still."""
    return rig.clamped or (rig.tree.ball is not None and not rig.pivot_moves)


def with_weightless_sensors(rig: Rig) -> Rig:
    """Return a rig with weightless sensors that sit fast, and without a play between free stops, as it is integrated.

    How a loose limb falls across the hinge's axis turns it about that axis by the square of the play at most.
    """
    play = rig.loose if rig.loose is not None and rig.loose.frequency else None
    weight = ROLL_OUT.sensor_mass * rig.segments[-1].mass
    return replace(rig, play=play, mounts=tuple(Mount(m.position, m.quaternion, mass=weight) for m in rig.mounts))


def rolled_out(
    rig: Rig, window: Swing, rate: float, step: float = ROLL_OUT.step_s, torque: Torque | None = None
) -> Played:
    """Return the motion of a rig by forces alone.

    Args:
        rig: whose base or pivot stands still.
        window: from whose start to whose end it is integrated.
        rate: rows a second.
        step: s, of the integration at most.
        torque: N m at stamps (n,) s, besides what the rig has: (n,) about a hinge.

    Raises:
        InputError: for a rig whose base moves, a window of less than six rows, or a simulation that does not stay
            finite.
    """
    if not can_swing(rig):
        raise InputError("roll-out: expected a base or a pivot that stands still, got one that is moved")
    steps = int(np.ceil(1.0 / (rate * step) - 1e-9))
    q, angle = integrated(rig, window, rate, 1.0 / (rate * steps), torque)
    q = rotations.continuous(q)
    return Played(window.start + np.arange(len(q)) / rate, q, np.zeros((len(q), 3)), angle)


def integrated(
    rig: Rig, window: Swing, rate: float, step: float, torque: Torque | None = None
) -> tuple[Array, Array | None]:
    """Return segment 1's attitude (n, 4) and the hinge's angle (n,) rad, None on a ball joint, in steps of `step` s."""
    light, state, rows = with_weightless_sensors(rig), window.state, int((window.end - window.start) * rate + 1e-6) + 2
    if rig.dry_friction and rig.tree.hinge is not None:
        since, split = torque_since(torque, window.start + step / 2), round(1 / (rate * step))
        angle, _ = swing_dry_hinge(light, state, rows, split, step, since)
        return np.broadcast_to(rig.base_quaternion, (rows, 4)), angle
    turns, angles, most = [], [], max(int(ROLL_OUT.chunk_s * rate), 1)
    for begin in range(0, rows, most):
        count = min(most, rows - begin)
        middle = window.start + begin / rate + step / 2  # MuJoCo holds a torque throughout a step
        pushed = torque_since(torque, middle)
        truth = next(iter(swing_many([light], [state], (count + 1) / rate, rate, pushed, step, threads=1)))
        first = truth.segments[0]
        turns.append(first.quaternion[:count])
        if truth.joint_angle is None or truth.joint_rate is None:
            state = Start(quaternion=first.quaternion[-1], rate=first.rate[-1])
            continue
        found = truth.joint_angle + 2 * np.pi * np.round((state.angle - truth.joint_angle[0]) / (2 * np.pi))
        angles.append(found[:count])
        state = Start(angle=float(found[-1]), angle_rate=float(truth.joint_rate[-1]))
    return np.concatenate(turns), np.concatenate(angles) if angles else None


def torque_since(torque: Torque | None, start: float) -> Torque | None:
    """Return a torque by the seconds since `start` s."""
    return None if torque is None else lambda time: torque(start + time)


def freedoms(rig: Rig) -> int:
    """Return how many numbers the state at a window's start has."""
    return 2 if rig.tree.hinge is not None else 6


def state_beside(rig: Rig, state: Start, step: Array) -> Start:
    """Return the state a step (2 or 6,) away: angle and rate, or a rotation vector and a rate in segment axes."""
    if rig.tree.hinge is not None:
        return replace(state, angle=state.angle + float(step[0]), angle_rate=state.angle_rate + float(step[1]))
    turned = rotations.multiply(state.quaternion, rotations.exp(step[:3]))
    return replace(state, quaternion=turned, rate=state.rate + step[3:])


def refined(rig: Rig, window: Swing, misfit: Misfit, seconds: float = ROLL_OUT.start_s) -> Swing:
    """Return a window with the state at its start that fits its first `seconds` best, from a state that is near.

    Derivatives serve as long as a step gains half of what they promise; then they are taken anew, for through an
    upright pose a limb is far from linear.
    """
    brief = replace(window, end=min(window.end, window.start + seconds))
    found, slope = misfit(brief)[1], slopes(rig, brief, misfit)
    anew = 1
    for _ in range(SOLVER.steps):
        step = best_step(slope, found)
        enough, promised = SOLVER.least_gain * (found @ found), found @ found - np.sum((found + slope @ step) ** 2)
        if promised <= enough or anew > SOLVER.refit_steps:
            break
        gain = 0.0
        for length in SOLVER.lengths:
            tried = replace(brief, state=state_beside(rig, brief.state, length * step))
            off = misfit(tried)[1]
            if off @ off < found @ found:
                gain, brief, found = float(found @ found - off @ off), tried, off
                break
        if gain < enough:
            break
        if gain < promised / 2:
            slope, anew = slopes(rig, brief, misfit), anew + 1
    return replace(window, state=brief.state)


def best_step(slope: Array, found: Array) -> Array:
    """Return the step (k,) or (k, m) that lowers residuals (n,) or (n, m) most; directions unseen stay.

    Their derivatives are `slope` (n, k).
    """
    return -np.linalg.pinv(slope, rcond=ALGEBRA.difference) @ found


def slopes(rig: Rig, window: Swing, misfit: Misfit) -> Array:
    """Return the derivatives (n, 2 or 6) of a window's misfit by the state at its start, by differences."""
    here = misfit(window)[1]
    moved = (
        misfit(replace(window, state=state_beside(rig, window.state, ROLL_OUT.difference * row)))[1]
        for row in np.eye(freedoms(rig))
    )
    return np.stack([(there - here) / ROLL_OUT.difference for there in moved], axis=1)


def horizon(rig: Rig, window: Swing, misfit: Misfit) -> float:
    """Return until when, in s, a window's roll-out is less uncertain than the noise for its start's sake."""
    if rig.tree.hinge is not None:
        return window.end
    ahead = ROLL_OUT.least_s
    while True:
        ahead *= 3  # chaos shows soon
        end = min(window.end, window.start + ahead)
        near = replace(window, end=end)
        time, slope = misfit(near)[0], slopes(rig, near, misfit)
        first = np.linalg.pinv(slope[time <= window.start + ROLL_OUT.start_s], rcond=ALGEBRA.difference)
        bins = ((time - window.start) / ROLL_OUT.bin_s).astype(int)
        power = np.bincount(bins, np.sum((slope @ first) ** 2, axis=1)) / np.maximum(np.bincount(bins), 1)
        beyond = np.flatnonzero(power > 1.0)
        beyond = beyond[beyond * ROLL_OUT.bin_s >= ROLL_OUT.least_s]
        if beyond.size:
            return window.start + float(beyond[0]) * ROLL_OUT.bin_s
        if end >= window.end:
            return window.end


__all__ = ["Misfit", "can_swing", "horizon", "refined", "rolled_out"]
