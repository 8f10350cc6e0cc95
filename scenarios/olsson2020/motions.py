"""The 14 motions of Olsson et al., Sensors 20 (2020) 3534, section 7.1, as a hand might make them.

A motion lasts `duration` s and is played with `MARGIN` s more before and after, which are cut away as
the authors cut the transitions away: time 0 of the signals here lies MARGIN before the motion proper.
docs/olsson2020-motions.md says what the paper gives and what was chosen.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from imubench.errors import InputError
from imubench.recording import positive
from imubench.scenarios.olsson2020.strokes import Clock, Composed, Step, Sum, strokes, wander
from imubench.sim.motion import AngleMotion
from imubench.sim.rigs import Mount, Rig, hinge, rod
from imubench.sim.signals import Signal, constant, hand

DURATION = 50.0  # s, of every motion
MARGIN = 1.0  # s
SHORTEST = 10.0  # s; a sequential motion needs time for two phases and the change of grip
RATE = 2.0  # rad/s rms of a segment about the hinge, slow motions
FREE_RATE = 1.2  # rad/s rms of each of heading, tilt and spin where the axis is free, slow motions
FREE_HINGE_RATE = 1.6  # rad/s rms of the hinge there
BEATS = (0.52, 0.6), (0.68, 0.76)  # Hz, strokes of the slow motions; two segments never keep one beat
ANY_BEAT = (0.52, 0.76)
BAND = np.deg2rad(4.5)  # the axis stays this close to horizontal, or to its 45 deg
CHANGE = 2.0  # s, to change the grip between the two phases of a sequential motion

HORIZONTAL, TILTING = 0.0, np.pi / 4  # rad, elevation of the axis

Build = Callable[[np.random.Generator, float, float, float], AngleMotion]  # rng, duration, pace, tilt


@dataclass(frozen=True)
class OlssonMotion:
    """One of the 14 motions; `build` draws it."""

    number: int
    name: str
    build: Build
    tilt: float = 0.0  # rad, elevation of the hinge axis above the horizon, where it is held
    pace: float = 1.0  # of the strokes
    screw: bool = False  # tight: the hinge does not turn

    def motion(self, rng: np.random.Generator, duration: float = DURATION) -> AngleMotion:
        """Return a random motion; the motion proper runs from MARGIN to MARGIN + `duration` s."""
        positive(duration, f"duration of motion {self.number}")
        if duration < SHORTEST:
            raise InputError(f"duration of motion {self.number}: expected {SHORTEST:g} s or more, got {duration:g} s")
        return self.build(rng, duration, self.pace, self.tilt)


def paper_rig(**changes: object) -> Rig:
    """Return a rig like the printed one of figure 3: two 10 cm segments, each with an MTw in a socket.

    The sockets hold both sensors' y axes along the hinge (eq. 69). Sizes are not in the paper: the
    34 x 58 mm IMUs sit 6 cm from the hinge on top of the segments, a few mm off their middle.
    """
    standard = {
        "mounts": (Mount(position=np.array([-0.06, 0.004, 0.02])), Mount(position=np.array([0.06, -0.003, 0.02]))),
        "segments": (rod(0.08, (-0.1, 0, 0), (-0.01, 0, 0), 0.015), rod(0.08, (0.01, 0, 0), (0.1, 0, 0), 0.015)),
    }
    return hinge(**(standard | changes))


def stationary(rng: np.random.Generator, duration: float, pace: float, tilt: float) -> AngleMotion:
    """Return a system at rest in any attitude, its joint at any angle."""
    heading, spin = rng.uniform(-np.pi, np.pi, size=2)
    elevation = np.arcsin(rng.uniform(-1, 1))
    return AngleMotion(constant(heading), constant(elevation), constant(spin), constant(_joint_angle(rng)))


def stiff(rng: np.random.Generator, duration: float, pace: float, tilt: float) -> AngleMotion:
    """Return a free rotation with the screw tight."""
    return _free(rng, duration, pace, constant(_joint_angle(rng)))


def sequential(rng: np.random.Generator, duration: float, pace: float, tilt: float) -> AngleMotion:
    """Return segment 1 turning on a segment 2 at rest, then the converse.

    A segment at rest does not move at all, so neither does the axis. In between, in CHANGE s, the rig is taken
    as a whole into another grip: the axis goes elsewhere within its band.
    """
    middle = MARGIN + duration / 2
    change = Step(middle - CHANGE / 2, middle + CHANGE / 2)
    phase = middle - CHANGE / 2 - MARGIN  # s, longer than either clock runs
    first, second = _two_segments(rng, phase, pace)
    spin1 = Composed(first, Clock(MARGIN, middle - CHANGE / 2))
    spin2 = Composed(second, Clock(middle + CHANGE / 2, MARGIN + duration))
    low, high = tilt - BAND, tilt + BAND
    start = rng.uniform(-np.pi, np.pi)

    def moved(before: float, after: float) -> Signal:
        return Sum(((1.0, constant(before)), (after - before, change)))

    return AngleMotion(
        heading=moved(start, start + rng.uniform(-0.2, 0.2)),
        tilt=moved(rng.uniform(low, high), rng.uniform(low, high)),
        **_turned(rng, spin1, spin2),
        x=moved(0.0, rng.uniform(-0.05, 0.05)),
        y=moved(0.0, rng.uniform(-0.05, 0.05)),
    )


def planar(rng: np.random.Generator, duration: float, pace: float, tilt: float) -> AngleMotion:
    """Return both segments turning at will about an axis that a hand holds about where it is."""
    end = 2 * MARGIN + duration
    first, second = _two_segments(rng, end, pace)
    start = rng.uniform(-np.pi, np.pi)
    return AngleMotion(
        heading=wander(rng, end, np.deg2rad(10.0), 0.3 * pace, start),
        tilt=wander(rng, end, BAND, 0.3 * pace, tilt),
        **_turned(rng, first, second),
        **_carried(rng, end, pace, 0.03),
    )


def simultaneous(rng: np.random.Generator, duration: float, pace: float, tilt: float) -> AngleMotion:
    """Return both segments turning at will, the axis free."""
    return _free(rng, duration, pace, _strokes(rng, 2 * MARGIN + duration, FREE_HINGE_RATE, pace, ANY_BEAT))


def _free(rng: np.random.Generator, duration: float, pace: float, angle: Signal) -> AngleMotion:
    end = 2 * MARGIN + duration
    drift = {"heading": 1.0, "tilt": 0.5, "spin": 1.0}  # rad, std: where the hand turns things to

    def turning(name: str) -> Signal:
        slow = hand(rng, end, drift[name], 0.15 * pace)
        return Sum(((1.0, _strokes(rng, end, FREE_RATE, pace, ANY_BEAT)), (1.0, slow)))

    turns = {name: turning(name) for name in drift}
    return AngleMotion(angle=angle, **turns, **_carried(rng, end, pace, 0.08))


def _strokes(rng: np.random.Generator, end: float, rate: float, pace: float, beats: tuple[float, float]) -> Signal:
    return strokes(rng, end, pace * rate * rng.uniform(0.95, 1.05), pace * rng.uniform(*beats))


def _two_segments(rng: np.random.Generator, end: float, pace: float) -> tuple[Signal, Signal]:
    """Return the turning of both segments about the hinge, in different beats."""
    order = rng.permutation(2)
    first, second = (_strokes(rng, end, RATE, pace, BEATS[i]) for i in order)
    return first, second


def _turned(rng: np.random.Generator, first: Signal, second: Signal) -> dict[str, Signal]:
    """Return spin and hinge angle that turn each segment by a signal of its own, from any attitude."""
    spin = Sum(((1.0, constant(rng.uniform(-np.pi, np.pi))), (1.0, first)))
    angle = Sum(((1.0, constant(_joint_angle(rng))), (1.0, second), (-1.0, first)))
    return {"spin": spin, "angle": angle}


def _carried(rng: np.random.Generator, end: float, pace: float, std: float) -> dict[str, Signal]:
    """Return the path of the joint centre in a hand, `std` m about where it started."""
    return {name: hand(rng, end, std, 1.0 * pace) for name in ("x", "y", "z")}


def _joint_angle(rng: np.random.Generator) -> float:
    return float(rng.uniform(-1.0, 1.0))


MOTIONS: dict[int, OlssonMotion] = {
    m.number: m
    for m in (
        OlssonMotion(1, "stationary", stationary, screw=True),
        OlssonMotion(2, "free rotation, stiff joint", stiff, screw=True),
        OlssonMotion(3, "sequential, horizontal axis", sequential, HORIZONTAL),
        OlssonMotion(4, "sequential, tilting axis", sequential, TILTING),
        OlssonMotion(5, "simultaneous planar, horizontal axis", planar, HORIZONTAL),
        OlssonMotion(6, "simultaneous planar, tilting axis", planar, TILTING),
        OlssonMotion(7, "simultaneous free", simultaneous),
        OlssonMotion(8, "stationary, again", stationary, screw=True),
        OlssonMotion(9, "fast free rotation, stiff joint", stiff, pace=2.0, screw=True),
        OlssonMotion(10, "fast sequential, horizontal axis", sequential, HORIZONTAL, pace=2.0),
        OlssonMotion(11, "fast sequential, tilting axis", sequential, TILTING, pace=2.0),
        OlssonMotion(12, "fast simultaneous planar, horizontal axis", planar, HORIZONTAL, pace=2.0),
        OlssonMotion(13, "fast simultaneous planar, tilting axis", planar, TILTING, pace=2.0),
        OlssonMotion(14, "fast simultaneous free", simultaneous, pace=2.0),
    )
}
"""The motions by their number in the paper."""
