"""Joints that are not a perfect hinge or ball: an axis or a centre that moves, a pivot that shakes, a slack encoder.

Priors: a knee's axis and centre follow its angle by a tenth (0.1 rad/rad) and by a centimetre or two (0.02 m/rad); a
hand holds a pivot within 0.5 m/s^2; the teeth of a gear leave a hundredth of a radian (a factor of e either way).
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Equation, Found, Numbers, Parameter, Scene, State, Values
from imubench.effects.smooth import beyond, magnitude
from imubench.effects.traits import Alike
from imubench.jets import Jet
from imubench.links import Link, shift, spin
from imubench.models.tree import BALL, HINGE
from imubench.sim.rigs import Rig

STOP, EDGE = 0.1, 0.02  # of backlash's range: over which its stops take hold, and begin to
RANGES = np.array([0.003, 0.006, 0.012, 0.025, 0.05])  # rad, of backlash, where a fit may begin
CREEP = 1e-3  # rad/s, below which the joint counts as still
BAND = (0.05, 0.95)  # of the power below the ends of what is reported as a band


class AxisCoupling(Effect):
    """Segment 2 turns across the hinge axis as the hinge turns."""

    name, place, law = "axis_coupling", "joint", "R2 = R1 Ry(q) Rx(c1 q) Rz(c2 q)"
    phrase = "a rotation off the hinge axis that follows the hinge angle"
    joints, needs = (HINGE,), ("imus",)
    alike = (
        Alike(
            "skin_sliding",
            "a turn that follows the hinge angle, before or after the sensor",
            "skin_sliding at imu2, nearly",
            at="joint",
            other_at="imu2",
        ),
    )
    parameters = (Parameter("coupling", (2,), "rad/rad", 0.1),)

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        angle, c = scene.turned(), p["coupling"]
        return link @ spin(0, *(c[[0]] * q for q in angle)) @ spin(2, *(c[[1]] * q for q in angle))

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        return replace(rig, coupling=np.asarray(numbers["coupling"], dtype=float))


class MovingCentre(Effect):
    """Segment 2's origin moves in segment 1 as the hinge turns."""

    name, place, law = "moving_centre", "joint", "segment 2's origin at slide q in segment 1"
    phrase = "a joint centre that moves with the hinge angle"
    joints, needs = (HINGE,), ("imus",)
    alike = (
        Alike(
            "skin_sliding",
            "the second segment seen from the first sensor moves alike",
            "skin_sliding at imu1 with the opposite slide, with a free base",
            at="joint",
            other_at="imu1",
            base="free",
        ),
    )
    parameters = (Parameter("slide", (3,), "m/rad", 0.02, axes="segment"),)

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        return shift(*(p["slide"] * q for q in scene.turned())) @ link

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        return replace(rig, centre=np.asarray(numbers["slide"], dtype=float))


class MovingPivot(Effect):
    """The pendulum's pivot accelerates, in world axes."""

    name, place, law = "moving_pivot", "joint", "the pivot accelerates, `std` on each axis within `band`"
    phrase = "a pivot that does not stay in its place"
    joints = (BALL,)
    carries_joint = True
    slow_share = 0.6  # of an accelerometer that walks 0.4, of one that rectifies 0.2 to 0.6, of pivots 0.98 and more
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

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        """Where the pivot goes is in the motion."""
        return replace(rig, pivot_moves=True)

    def injected_rig(self, rig: Rig, numbers: Numbers) -> Rig:
        """With the motion that moves it; see `sim.injected.carried`."""
        return rig


class Backlash(Effect):
    """The encoder's side of the joint follows with free play: the gap between the two sides stays within a range.

    The gap d follows the joint until it meets a stop, d' = q' - |q'| s(d / range): s is the force of the stops,
    nothing inside, +-1 where |d| = range, so that the law does not depend on how fast the joint turns.
    """

    name, place, law = "backlash", "joint", "the encoder reads q - d, |d| <= range, d' = q' until a stop is met"
    phrase = "backlash between joint and encoder"
    joints, needs = (HINGE,), ("encoders", "imus")
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

    def encoder_reads(self, angle: Array, numbers: Numbers) -> Array:
        """The gap at first is `gap` rad, nothing where nobody told it."""
        range_, gap = (float(np.ravel(numbers.get(key, np.zeros(1)))[0]) for key in ("range", "gap"))
        return self.played(angle, range_, gap)

    @staticmethod
    def played(angle: Array, range_: float, gap: float = 0.0) -> Array:
        """Return the exact encoder's side (n,) rad for joint angles (n,), the gap at first `gap`."""
        out = np.empty_like(angle)
        side = angle[0] - gap
        for i, q in enumerate(angle):  # what comes next depends on where it stood
            side = min(max(side, q - range_), q + range_)
            out[i] = side
        return out


EFFECTS: tuple[Effect, ...] = (AxisCoupling(), MovingCentre(), MovingPivot(), Backlash())
