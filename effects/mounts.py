"""Sensors that are not where the model has them: all along, from some time on, or with the joint's angle.

Translations in segment axes, rotations in nominal sensor axes, applied on the right.

Priors: a sensor that is not where it should be may sit anywhere on its segment, and be turned far (0.15 m, 0.5 rad);
one that slips goes a few centimetres and some degrees (0.02 m, 0.1 rad); skin slides a few centimetres and turns some
degrees over a radian of the joint (0.02 m/rad, 0.1 rad/rad).
"""

from collections.abc import Mapping

import numpy as np

from imubench.arrays import Array
from imubench.effects.effect import Effect, Parameter, Scene, Values
from imubench.jets import Jet, rotation
from imubench.links import Link, shift, small_turn
from imubench.models.tree import BALL, HINGE

SLIP = 0.2  # s that a mount takes to slip
LONGEST = 0.3  # s that it may take: how it moves in between is not known


class MountPose(Effect):
    """The sensor is not where the model has it."""

    name, place, law = "mount_pose", "imu", "q = q_model exp(rotation), p = p_model + translation"
    parameters = (Parameter("rotation", (3,), "rad", 0.5), Parameter("translation", (3,), "m", 0.15))

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        return shift(p["translation"]) @ link @ Link(rotation(p["rotation"]))


def slipped(time: Jet, start: Jet, width: float = SLIP) -> tuple[Jet, Jet, Jet]:
    """Return a step (n, 1) from 0 to 1 that takes `width` s from `start` on, and its derivatives by time.

    With u from 0 to 1 in between: 10 u^3 - 15 u^4 + 6 u^5, whose first two derivatives are zero at both ends.
    """
    raw = (time - start) * (1 / width)
    inside = (raw.value > 0) & (raw.value < 1)
    u = raw.through(np.clip(raw.value, 0.0, 1.0), inside.astype(float))
    return (
        u * u * u * (10.0 + u * (6.0 * u - 15.0)),
        30.0 * u * u * (1.0 - u) * (1.0 - u) * (1 / width),
        60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) * (1 / width**2),
    )


class MountShift(Effect):
    """The sensor slips once."""

    name, place, law = "mount_shift", "imu", "as mount_pose, from `time` on, within 0.2 s"
    parameters: tuple[Parameter, ...] = (
        Parameter("rotation", (3,), "rad", 0.1),
        Parameter("translation", (3,), "m", 0.02),
        Parameter("time", (), "s", 0.5),
    )

    def grid(self, seconds: float) -> dict[str, Array]:
        return {"time": np.arange(0.5, max(seconds - 0.5, 0.6), 0.5)}

    def blind(self, values: Mapping[str, Array]) -> tuple[tuple[float, float], ...]:
        start = float(values["time"][0])
        return ((start - LONGEST / 2, start + LONGEST),)

    def began(self, time: Jet, p: Values) -> Jet:
        """Return when the slip begins that acts at times (n, 1) s."""
        return p["time"]

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        step = slipped(scene.time, self.began(scene.time, p))
        moved = shift(*(p["translation"] * s for s in step))
        return moved @ link @ small_turn(*(p["rotation"] * s for s in step))


class SkinSliding(Effect):
    """The sensor moves with the skin as the joint turns."""

    name, place, law = "skin_sliding", "imu", "displaced by slide q, turned by twist q"
    joints = (HINGE, BALL)
    scales_angle = True
    parameters = (Parameter("slide", (3,), "m/rad", 0.02), Parameter("twist", (3,), "rad/rad", 0.1))

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        angle = scene.turned()
        moved = shift(*(p["slide"] * q for q in angle))
        return moved @ link @ small_turn(*(p["twist"] * q for q in angle))


EFFECTS: tuple[Effect, ...] = (MountPose(), MountShift(), SkinSliding())
