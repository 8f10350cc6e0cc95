"""Sensors that are not where the model has them: all along, from some time on, or with the joint's angle.

Translations in segment axes, rotations in nominal sensor axes, applied on the right.

Priors: a sensor that is not where it should be may sit anywhere on its segment, and be turned far (0.15 m, 0.5 rad);
one that slips goes a few centimetres and some degrees (0.02 m, 0.1 rad); skin slides a few centimetres and turns some
degrees over a radian of the joint (0.02 m/rad, 0.1 rad/rad).
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.effects.effect import Effect, Numbers, Parameter, Scene, Values
from imubench.effects.traits import Alike
from imubench.jets import Jet, rotation
from imubench.links import Link, shift, small_turn
from imubench.models.tree import BALL, HINGE
from imubench.recording import STANDARD_GRAVITY
from imubench.sim.rigs import Mount, Slip

SLIP = 0.2  # s that a mount takes to slip
LONGEST = 0.3  # s that it may take: how it moves in between is not known


class MountPose(Effect):
    """The sensor is not where the model has it."""

    name, place, law = "mount_pose", "imu", "q = q_model exp(rotation), p = p_model + translation"
    phrase = "{imu} sitting elsewhere than the model has it"
    misplaces = True
    parameters = (
        Parameter("rotation", (3,), "rad", 0.5, about=True),
        Parameter("translation", (3,), "m", 0.15, axes="segment"),
    )

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        return shift(p["translation"]) @ link @ Link(rotation(p["rotation"]))

    def on_mount(self, mount: Mount, numbers: Numbers) -> Mount:
        turn = rotations.multiply(mount.quaternion, rotations.exp(np.asarray(numbers["rotation"])))
        return replace(mount, position=mount.position + np.asarray(numbers["translation"]), quaternion=turn)


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
    phrase = "{imu} moving to another place during the recording"
    onset = "time"
    parameters: tuple[Parameter, ...] = (
        Parameter("rotation", (3,), "rad", 0.1, about=True),
        Parameter("translation", (3,), "m", 0.02, axes="segment"),
        Parameter("time", (), "s", 0.5),
    )

    def grid(self, seconds: float) -> dict[str, Array]:
        return {"time": np.arange(0.5, max(seconds - 0.5, 0.6), 0.5)}

    def at_moments(self, moments: Array) -> "Effect":
        return Slips(moments)

    def blind(self, values: Mapping[str, Array]) -> tuple[tuple[float, float], ...]:
        start = float(values["time"][0])
        return ((start - LONGEST / 2, start + LONGEST),)

    def course_std(self, values: Mapping[str, Array]) -> tuple[float, float]:
        """Return the law's own peaks: what else gets there within as long is off by about as much.

        Of a step of 1 within T they are 15/8 / T and 10/sqrt(3) / T^2; a turn that is not known moves gravity, too.
        """
        turned, moved = (float(np.linalg.norm(values[name])) for name in ("rotation", "translation"))
        return turned * 1.875 / SLIP, moved * 5.774 / SLIP**2 + turned * STANDARD_GRAVITY

    def began(self, time: Jet, p: Values) -> Jet:
        """Return when the slip begins that acts at times (n, 1) s."""
        return p["time"]

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        step = slipped(scene.time, self.began(scene.time, p))
        moved = shift(*(p["translation"] * s for s in step))
        return moved @ link @ small_turn(*(p["rotation"] * s for s in step))

    def on_mount(self, mount: Mount, numbers: Numbers) -> Mount:
        return replace(mount, slip=Slip(float(numbers["time"]), numbers["translation"], numbers["rotation"]))


class Slips(MountShift):
    """A slip that begins anew at every one of some moments: its columns are those of each alone, as long as it lasts.

    While it slips a sensor turns by itself, which its gyroscope reads: a mount that is another from a moment on, and
    does not turn there, explains little of it.
    """

    name = "slips"  # beside whatever else a fit says of the mount
    parameters = MountShift.parameters[:2]

    def __init__(self, moments: Array) -> None:
        self.moments = moments

    def began(self, time: Jet, p: Values) -> Jet:
        """Return the last of the moments before each time (n, 1) s."""
        last = np.searchsorted(self.moments, time.value[:, 0], side="right") - 1
        return Jet(self.moments[np.maximum(last, 0)][:, None])


class SkinSliding(Effect):
    """The sensor moves with the skin as the joint turns."""

    name, place, law = "skin_sliding", "imu", "displaced by slide q, turned by twist q"
    phrase = "{imu} sliding along as the joint moves"
    joints = (HINGE, BALL)
    scales_angle = True
    alike = (
        Alike(
            "moving_centre",
            "the second segment seen from the first sensor moves alike",
            "at imu1, without a twist: moving_centre with the opposite slide; at imu2, nearly: axis_coupling",
            at="imu1",
            other_at="joint",
            base="free",
        ),
        Alike(
            "axis_coupling",
            "a turn that follows the hinge angle, before or after the sensor",
            at="imu2",
            other_at="joint",
        ),
    )
    parameters = (
        Parameter("slide", (3,), "m/rad", 0.02, axes="segment"),
        Parameter("twist", (3,), "rad/rad", 0.1, about=True),
    )

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        angle = scene.turned()
        moved = shift(*(p["slide"] * q for q in angle))
        return moved @ link @ small_turn(*(p["twist"] * q for q in angle))

    def on_mount(self, mount: Mount, numbers: Numbers) -> Mount:
        return replace(mount, slide=numbers["slide"], twist=numbers["twist"])


EFFECTS: tuple[Effect, ...] = (MountPose(), MountShift(), SkinSliding())
