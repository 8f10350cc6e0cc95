"""Torques that the equation of motion leaves out, and a body that is not as declared. Free swings show them.

Priors, for limbs and rigs of some kilograms: friction and drag that stop a swing within seconds to minutes
(0.05 N m s/rad, 0.1 N m, 0.05 N m s^2/rad^2), a cable as stiff as the weight (1 N m/rad), a stop that stops a
limb within some hundredths of a radian (100 N m/rad), an inertia estimated within a fifth, gravity within 0.1 m/s^2.
"""

from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Numbers, Parameter, Scene, Values
from imubench.effects.smooth import beyond, magnitude, touching
from imubench.effects.traits import Alike
from imubench.jets import Jet, stack
from imubench.models.tree import BALL, HINGE
from imubench.recording import STANDARD_GRAVITY, Recording
from imubench.sim.joints import Stop
from imubench.sim.rigs import Rig, inertia_about

STUCK = 0.02  # rad/s, below which dry friction gives way
EDGE = 0.005  # rad, over which a stop begins
BOUNCE, BOUNCE_RATIO = 25.0, 0.3
"""Hz and damping ratio of a limb on an end stop of which nobody says how stiff it is: it stops within some hundredths
of a radian, and knocks a few times."""


class _Torque(Effect):
    joints = (HINGE, BALL)
    needs = ("free_swings",)


def _resisting(numbers: Numbers, key: str) -> float:
    """Return the size of what resists: a fit may go a little below nothing."""
    return max(float(numbers.get(key, np.zeros(()))), 0.0)


class ViscousFriction(_Torque):
    """Friction that grows with the rate."""

    name, place, law = "viscous_friction", "joint", "torque -c w"
    phrase = "viscous friction in the joint"
    friction = True
    parameters = (Parameter("c", (), "N m s/rad", 0.05, sided=True),)

    def torque(self, scene: Scene, p: Values) -> Jet:
        rate, _ = scene.jointed()
        return -p["c"] * rate

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        return replace(rig, damping=_resisting(numbers, "c"))


class DryFriction(_Torque):
    """Friction of one size, against the motion."""

    name, place, law = "dry_friction", "joint", "torque -t w / |w|, |w| taken as sqrt(w^2 + (0.02 rad/s)^2)"
    phrase = "dry friction in the joint"
    friction = torque_jumps = True
    holds_by = "t"
    parameters = (Parameter("t", (), "N m", 0.1, sided=True),)

    def torque(self, scene: Scene, p: Values) -> Jet:
        rate, _ = scene.jointed()
        return -p["t"] * rate / magnitude(rate, STUCK)

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        return replace(rig, dry_friction=_resisting(numbers, "t"))


class AirDrag(_Torque):
    """Drag that grows with the rate's square."""

    name, place, law = "air_drag", "joint", "torque -d |w| w"
    phrase = "air drag"
    friction = True
    parameters = (Parameter("d", (), "N m s^2/rad^2", 0.05, sided=True),)

    def torque(self, scene: Scene, p: Values) -> Jet:
        rate, _ = scene.jointed()
        return -p["d"] * magnitude(rate, 1e-6) * rate

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        return replace(rig, drag=_resisting(numbers, "d"))


class JointSpring(_Torque):
    """A cable or a spring across the joint; on a ball joint it acts on the swing q, about the world's y.

    Or, to keep its energy k (q - q0)^2 / 2 however the limb moves, about the gradient of q by a rotation,
    (e_y - z_y z) / (1 - z_y^2), z the limb's axis: in the plane of the swing the same, and never about z.
    """

    name, place, law = "joint_spring", "joint", "torque -k (q - q0)"
    phrase = "a spring, such as a cable, across the joint"
    rests_at = "q0"
    parameters = (Parameter("k", (), "N m/rad", 1.0, sided=True), Parameter("q0", (), "rad", 0.5))

    def __init__(self, conservative: bool = False) -> None:
        self.variant = "conservative" if conservative else ""

    @property
    def conservative(self) -> bool:
        """Whether it keeps its energy on a ball joint."""
        return self.variant == "conservative"

    def places(self, recording: Recording) -> tuple[str, ...]:
        return super().places(recording) if recording.tree.ball is not None or not self.conservative else ()

    def torque(self, scene: Scene, p: Values) -> Jet:
        (angle, _, _), (_, axis) = scene.turned(), scene.jointed()
        return -p["k"] * (angle - p["q0"]) * (gradient(axis) if self.conservative else axis)

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        stiffness, slack = (float(numbers.get(key, np.zeros(()))) for key in ("k", "q0"))
        return replace(rig, stiffness=stiffness, spring_angle=slack, spring_conserves=self.conservative)

    def injected_rig(self, rig: Rig, numbers: Numbers) -> Rig:
        """On a ball joint it keeps its energy, as a cable does; see `sim.ball`."""
        return replace(self.on_rig(rig, numbers, weighed=False), spring_conserves=rig.tree.ball is not None)


def gradient(axis: Jet) -> Jet:
    """Return the gradient (n, 3) of a pendulum's swing by a rotation from the world's y, both in the limb's axes."""
    x, y = axis[[0]], axis[[1]]
    return stack(x, y, 0.0 * x) / (x * x + y * y)


class EndStop(_Torque):
    """A stiff stop on one side; how stiff and how damped is fitted with it."""

    name, place, law = "end_stop", "joint", "torque -(k depth + b rate) beyond `angle`, on the side of its sign"
    phrase = "a stop at the end of the joint's range"
    knocks = torque_jumps = True
    stops_at = "angle"
    parameters = (
        Parameter("angle", (), "rad", 0.5, start=1.0),
        Parameter("stiffness", (), "N m/rad", 1.5, start=100.0, log=True, reported=False),
        Parameter("damping", (), "N m s/rad", 1.5, start=0.3, log=True, reported=False),
    )

    def grid(self, seconds: float) -> dict[str, Array]:
        reach = np.arange(0.1, 2.6, 0.1)
        return {"angle": np.concatenate([-reach[::-1], reach])}

    def torque(self, scene: Scene, p: Values) -> Jet:
        (angle, rate, _), (_, axis) = scene.turned(), scene.jointed()
        side = np.where(p["angle"].value < 0, -1.0, 1.0)
        over = side * (angle - p["angle"])
        held = p["stiffness"] * beyond(over, EDGE) * side + p["damping"] * touching(over, EDGE) * rate
        return -held * axis

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        usual = {p.name: p.start for p in self.parameters}
        told = (np.asarray(numbers.get(key, usual[key])) for key in ("angle", "stiffness", "damping"))
        return replace(rig, stop=Stop(*(float(number) for number in told)))

    def injected_rig(self, rig: Rig, numbers: Numbers) -> Rig:
        """Where nobody says how stiff it is, the limb bounces on it at `BOUNCE` Hz."""
        inertia, w = inertia_about(rig, np.eye(3)[1]), 2 * np.pi * BOUNCE
        bounce = {"stiffness": np.asarray(inertia * w**2), "damping": np.asarray(inertia * 2 * BOUNCE_RATIO * w)}
        return self.on_rig(rig, {**bounce, **numbers}, weighed=False)


class Inertia(Effect):
    """The body swings faster or slower than declared; its weight is as declared."""

    name, place, law = "inertia", "body", "m l / I about the joint is `scale` times the declared one"
    phrase = "an inertia that is not the declared one"
    joints, needs = (HINGE, BALL), ("free_swings",)
    parameters = (Parameter("scale", (), "1", 0.2, start=1.0),)

    def lighter(self, p: Values) -> Jet:
        return p["scale"]

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        return replace(rig, inertia_scale=float(numbers["scale"]))

    def injected_rig(self, rig: Rig, numbers: Numbers) -> Rig:
        """It is the declared body that is another one; see `sim.injected.believed`."""
        return rig


class Gravity(Effect):
    """The magnitude of gravity differs."""

    name, place, law = "gravity", "world", "|gravity| = g"
    phrase = "a gravity that is not the declared one"
    alike = (
        Alike(
            "accel_scale",
            "a scale that all accelerometers share is another unit of force",
            "one accel_scale that all accelerometers share, but in free swings",
            at="world",
            in_swings=False,
        ),
    )
    parameters = (Parameter("g", (), "m/s^2", 0.1, start=STANDARD_GRAVITY),)

    def places(self, recording: Recording) -> tuple[str, ...]:
        seen = recording.gravity and (recording.imus or recording.poses)  # in a swing alone it is the body's
        return super().places(recording) if seen else ()

    def suited(self, recording: Recording) -> Effect:
        return self.starting(g=recording.gravity)

    def gravity(self, gravity: Jet, p: Values) -> Jet:
        return gravity / magnitude(gravity, 0.0) * p["g"]

    def on_rig(self, rig: Rig, numbers: Numbers, weighed: bool) -> Rig:
        return replace(rig, gravity=float(numbers["g"]))


EFFECTS: tuple[Effect, ...] = (
    ViscousFriction(), DryFriction(), AirDrag(), JointSpring(), JointSpring(conservative=True), EndStop(), Inertia(),
    Gravity(),
)  # fmt: skip
