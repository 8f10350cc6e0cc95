"""Joints that are not a perfect hinge or ball: play, an axis or a centre that moves, a pivot that shakes.

Priors: a worn hinge gives some hundredths of a radian across its axis (0.04 rad); a knee's axis and centre
follow its angle by a tenth (0.1 rad/rad) and by a centimetre or two (0.02 m/rad); a hand holds a pivot
within 0.5 m/s^2; the teeth of a gear leave a hundredth of a radian (a factor of e either way).
"""

from collections.abc import Mapping

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Equation, Found, Parameter, Scene, State, Values
from imubench.effects.smooth import beyond, magnitude
from imubench.jets import Jet
from imubench.links import Link, shift, small_turn, spin

QUICK, WHOLE = 0.5, 0.8  # s, windows in which play's direction and its range are seen
REACHED = 0.9  # of the windows, that span less than what is reported as a range
DRAWS = 100  # of windows, for the scatter of both
STOP, EDGE = 0.1, 0.02  # of backlash's range: over which its stops take hold, and begin to
RANGES = np.array([0.003, 0.006, 0.012, 0.025, 0.05])  # rad, of backlash, where a fit may begin
CREEP = 1e-3  # rad/s, below which the joint counts as still
BAND = (0.05, 0.95)  # of the power below the ends of what is reported as a band


class JointPlay(Effect):
    """Segment 2 rotates across the hinge axis, within a range."""

    name, place, law = "joint_play", "joint", "R2 = R1 Ry(q) exp(a, 0, b), |(a, b)| < range"
    rigs, needs = ("hinge",), ("imus",)
    states = (State("rotation", 2, 0.04),)
    found = (Found("range", (), "rad"), Found("direction", (), "rad"))

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        across = [np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])] * 3
        return link @ small_turn(*(x.at(m) for x, m in zip(scene.own("rotation"), across, strict=True)))

    def read(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Range and direction of the axis along which the two rotations vary most; a direction is known up to pi.

        In short windows: there a joint knocks from one side to the other, and what drifts, as the gyroscopes'
        difference does, hardly moves.
        """
        quick, whole = (windows(states["rotation"], step, seconds) for seconds in (QUICK, WHOLE))
        return dict(zip(("range", "direction"), _played(quick, whole), strict=True))

    def read_error(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Of other windows, and of the range a quarter: springs seldom reach it, and what drifts widens it.

        Eleven of two blind runs were off by 29 % RMS, springs by -43 to 29 %.
        """
        quick, whole = (windows(states["rotation"], step, seconds) for seconds in (QUICK, WHOLE))
        size, direction = _played(quick, whole)
        rng = np.random.default_rng(0)
        drawn = [_played(*(w[rng.integers(0, len(w), len(w))] for w in (quick, whole))) for _ in range(DRAWS)]
        turned = np.array([(d - direction + np.pi / 2) % np.pi - np.pi / 2 for _, d in drawn])
        return {"range": np.hypot(np.std([r for r, _ in drawn]), 0.25 * size), "direction": np.asarray(np.std(turned))}


def windows(states: Array, step: float, seconds: float) -> Array:
    """Return states (n, m) less their means in windows of some seconds that overlap by half, (windows, k, m)."""
    k = min(max(round(seconds / step), 2), len(states))
    cut = np.stack([states[i : i + k] for i in range(0, len(states) - k + 1, max(k // 2, 1))])
    return np.asarray(cut - cut.mean(axis=1, keepdims=True))


def _played(quick: Array, whole: Array) -> tuple[Array, Array]:
    """Return the range of play and its direction from windows of its rotations."""
    axis = np.linalg.svd(np.einsum("kni,knj->ij", quick, quick))[0][:, 0]
    axis *= 1.0 if axis[0] >= 0 else -1.0
    return np.quantile(np.ptp(whole @ axis, axis=1), REACHED) / 2, np.asarray(np.arctan2(axis[1], axis[0]))


class AxisCoupling(Effect):
    """Segment 2 turns across the hinge axis as the hinge turns."""

    name, place, law = "axis_coupling", "joint", "R2 = R1 Ry(q) Rx(c1 q) Rz(c2 q)"
    rigs, needs = ("hinge",), ("imus",)
    parameters = (Parameter("coupling", (2,), "rad/rad", 0.1),)

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        angle, c = scene.turned(), p["coupling"]
        return link @ spin(0, *(c[[0]] * q for q in angle)) @ spin(2, *(c[[1]] * q for q in angle))


class MovingCentre(Effect):
    """Segment 2's origin moves in segment 1 as the hinge turns."""

    name, place, law = "moving_centre", "joint", "segment 2's origin at slide q in segment 1"
    rigs, needs = ("hinge",), ("imus",)
    parameters = (Parameter("slide", (3,), "m/rad", 0.02),)

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        return shift(*(p["slide"] * q for q in scene.turned())) @ link


class MovingPivot(Effect):
    """The pendulum's pivot accelerates, in world axes."""

    name, place, law = "moving_pivot", "joint", "the pivot accelerates, `std` on each axis within `band`"
    rigs = ("pendulum",)
    states = (State("acceleration", 3, 0.5),)
    found = (Found("std", (), "m/s^2"), Found("band", (2,), "Hz"))

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        acceleration = scene.own("acceleration")[0]
        if scene.segment.turn is not None:
            acceleration = scene.segment.turn.back(acceleration)
        return link @ shift(Jet(np.zeros((1, 3))), accel=acceleration)

    def read(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        x = states["acceleration"] - states["acceleration"].mean(axis=0)
        power = np.cumsum(np.sum(np.abs(np.fft.rfft(x, axis=0)) ** 2, axis=1))
        ends = np.searchsorted(power, np.array(BAND) * power[-1])
        return {"std": np.sqrt(np.mean(x**2)), "band": np.fft.rfftfreq(len(x), step)[ends]}


class Backlash(Effect):
    """The encoder's side of the joint follows with free play: the gap between the two sides stays within a range.

    The gap d follows the joint until it meets a stop, d' = q' - |q'| s(d / range): s is the force of the stops,
    nothing inside, +-1 where |d| = range, so that the law does not depend on how fast the joint turns.
    """

    name, place, law = "backlash", "joint", "the encoder reads q - d, |d| <= range, d' = q' until a stop is met"
    rigs, needs = ("hinge",), ("encoders", "imus")
    states = (State("gap", 1, 0.02),)
    parameters = (Parameter("range", (), "rad", 1.0, start=0.01, log=True),)

    def encoder(self, angle: Jet, scene: Scene, p: Values) -> Jet:
        return angle - scene.own("gap")[0]

    def equations(self, scene: Scene, p: Values) -> list[Equation]:
        gap, rate, _ = scene.own("gap")
        _, turning, _ = scene.turned()
        u = gap / p["range"]
        stops = beyond(u - (1 - STOP), EDGE) - beyond(-u - (1 - STOP), EDGE)
        return [Equation("gap", rate - turning + magnitude(turning, CREEP) * stops * (1 / STOP), 0.05)]

    def grid(self, seconds: float) -> dict[str, Array]:
        return {"range": RANGES}

    def follow(self, scene: Scene, p: Values) -> dict[str, Array]:
        angle = scene.turned()[0].value[:, 0]
        return {"gap": (angle - self.played(angle, float(p["range"].value[0, 0])))[:, None]}

    @staticmethod
    def played(angle: Array, range_: float) -> Array:
        """Return the exact encoder's side (n,) rad for joint angles (n,), the gap at first in its middle."""
        out = np.empty_like(angle)
        side = angle[0]
        for i, q in enumerate(angle):  # what comes next depends on where it stood
            side = min(max(side, q - range_), q + range_)
            out[i] = side
        return out


EFFECTS: tuple[Effect, ...] = (JointPlay(), AxisCoupling(), MovingCentre(), MovingPivot(), Backlash())
