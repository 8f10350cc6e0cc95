"""What an effect is: one physical law, its parameters, and where in the chain of a measurement it acts."""

from collections.abc import Callable, Iterator, Mapping
from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array
from imubench.effects.parameters import Change, Found, Parameter
from imubench.effects.traits import OF_FAULT, Correction, Traits
from imubench.errors import InputError
from imubench.jets import Jet
from imubench.links import Link, Motion
from imubench.models.tree import Tree
from imubench.recording import Imu, Recording

if TYPE_CHECKING:
    from imubench.sim.rigs import Mount, Rig

Place = Literal["imu", "joint", "body", "world"]


@dataclass(frozen=True)
class Reading:
    """What the sensing elements of one IMU meet, in sensor axes."""

    gyro: Jet  # (n, 3) rad/s
    accel: Jet  # (n, 3) m/s^2, specific force
    time: Jet  # (n, 1) s since the recording's start


@dataclass(frozen=True)
class Error:
    """What an effect adds to a reading; errors act side by side on the true signal."""

    gyro: Jet | None = None  # (n, 3) rad/s
    accel: Jet | None = None  # (n, 3) m/s^2


@dataclass(frozen=True)
class Scene:
    """Where the rig is at some times, as an effect may ask for it; (n, m) everywhere."""

    time: Jet  # (n, 1) s since the recording's start
    segment: Motion  # of the segment that the effect's sensor sits on; at a joint the swinging one where there is none
    angle: Jet | None = None  # (n, 1) rad, hinge angle or pendulum swing
    angle_rate: Jet | None = None  # rad/s
    angle_accel: Jet | None = None  # rad/s^2
    joint_rate: Jet | None = None  # (n, 3) rad/s, the joint's angular velocity in the swinging segment's axes
    joint_axis: Jet | None = None  # (n, 3) what `angle` turns about, in the same axes
    state: Callable[[str, int], Jet] | None = None  # the effect's own splines and their derivatives
    mount: Link | None = None  # sensor on segment: before the effect in `mount`, with all effects in `equations`
    sensor: Motion | None = None  # of the sensing point, with all effects; in `equations`

    def turned(self) -> tuple[Jet, Jet, Jet]:
        """Return angle, rate and acceleration of the joint; `InputError` where there is none."""
        if self.angle is None or self.angle_rate is None or self.angle_accel is None:
            raise InputError("expected a rig with a joint whose angle is known, got none")
        return self.angle, self.angle_rate, self.angle_accel

    def jointed(self) -> tuple[Jet, Jet]:
        """Return the joint's angular velocity and axis (n, 3); `InputError` where there is no joint."""
        if self.joint_rate is None or self.joint_axis is None:
            raise InputError("expected a rig with a joint, got none")
        return self.joint_rate, self.joint_axis

    def own(self, name: str) -> tuple[Jet, Jet, Jet]:
        """Return one of the effect's states and its first two derivatives."""
        if self.state is None:
            raise InputError(f"expected the state '{name}', got none")
        return self.state(name, 0), self.state(name, 1), self.state(name, 2)

    def mounted(self) -> tuple[Link, Motion]:
        """Return the sensor on its segment and its motion; `InputError` where there is no sensor."""
        if self.mount is None or self.sensor is None:
            raise InputError("expected a sensor on its mount, got none")
        return self.mount, self.sensor


@dataclass(frozen=True)
class Equation:
    """A law that a state obeys: its residual (n, m) is zero up to `std`."""

    name: str
    residual: Jet
    std: float  # per row; where a fit begins, which estimates it


@dataclass(frozen=True)
class State:
    """Numbers that follow a law over time, a spline in the fit."""

    name: str
    width: int
    std: float  # their plausible size, for a prior
    jumps: bool = False  # whether they may go quickly now and then, as what falls over does


Values = Mapping[str, Jet]
Numbers = Mapping[str, Array]  # parameter -> (k,), as a diagnosis reports or a simulation is given it
Stage = Literal[
    "clock", "gravity", "joint", "encoder", "mount", "filtered", "error", "lighter", "torque", "equations", "corrupt"
]
"""Where in the chain of a measurement an effect may act: the method that its class overrides."""
Setting = float | str | tuple[str, ...]


class Effect(Traits):
    """One left-out law. A subclass names it, overrides the stage where it acts and declares what is special of it.

    Everything is written on `Jet`, so the same lines simulate (no derivatives) and fit (exact Jacobian).
    Objects of one class may differ in their settings: they share the name and are told apart by `variant`.
    """

    name: ClassVar[str]
    place: ClassVar[Place]
    law: ClassVar[str]  # one line, with its symbols
    joints: ClassVar[tuple[str, ...]] = ()  # kinds of joint of which the rig must have one; (): it needs none
    needs: ClassVar[tuple[str, ...]] = ()  # of a recording: "free_swings", "encoders", "imus"
    of_the_sensor: ClassVar[Change | None] = None  # until the sensor's next recording; None: that need not have it
    given: ClassVar[bool] = False  # whether it is known beforehand, and no diagnosis asks whether it is there
    variant: str = ""
    scale: str = ""  # the parameter that all of what drives its states is multiplied by, where one is
    settings: Mapping[str, Setting] = {}  # what is chosen, not fitted
    parameters: tuple[Parameter, ...] = ()
    found: tuple[Found, ...] = ()
    states: tuple[State, ...] = ()

    def fits(self, tree: Tree) -> bool:
        """Return whether a rig has what the effect acts on; a rig that nobody has read has not."""
        return bool(tree.segments) and (not self.joints or tree.kind in self.joints)

    def places(self, recording: Recording) -> tuple[str, ...]:
        """Return where the effect may act on a recording's rig."""
        if not self.fits(recording.tree) or not all(getattr(recording, need) for need in self.needs):
            return ()
        if "free_swings" in self.needs and recording.body is None:
            return ()
        return tuple(i.name for i in recording.imus) if self.place == "imu" else (self.place,)

    def suited(self, recording: Recording) -> "Effect":
        """Return the effect with its priors about what a recording declares."""
        return self

    def starting(self, **starts: ArrayLike) -> "Effect":
        """Return the same effect with priors about other values, a point of its grid for one."""
        known = [p.name for p in self.parameters]
        if missing := [name for name in starts if name not in known]:
            raise InputError(f"{self.name}: unknown parameter '{missing[0]}'; known: {', '.join(known)}")
        out = copy(self)
        out.parameters = tuple(
            replace(p, start=tuple(np.atleast_1d(np.asarray(starts[p.name], dtype=float)).reshape(-1).tolist()))
            if p.name in starts
            else p
            for p in self.parameters
        )
        return out

    def as_large(self, times: float) -> "Effect":
        """Return the same effect with priors so many times as wide."""
        out = copy(self)
        out.parameters = tuple(replace(p, std=p.std * times) for p in self.parameters)
        return out

    def grid(self, seconds: float) -> dict[str, Array]:
        """Return the starts (k,) to try of the parameters in which the law is far from linear."""
        return {}

    def in_time(self, values: Mapping[str, Array], step: float) -> Mapping[str, Array]:
        """Return fitted parameters (k,) as its law has them in continuous time; a fit has knots `step` s apart."""
        return values

    def collocated(self, values: Mapping[str, Array], step: float) -> Mapping[str, Array]:
        """Return parameters (k,) of its law in continuous time as a fit with knots `step` s apart has them."""
        return values

    def read(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Return the `found` parameters from fitted ones (k,) and states (n, m) sampled every `step` s."""
        return {}

    def read_error(self, values: Mapping[str, Array], states: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Return standard deviations of `found` parameters, where the states' own scatter tells them."""
        return {}

    def changing(self, values: Mapping[str, Array], imu: Imu) -> dict[str, float]:
        """Return the standard deviation that parameters have beyond the fit's, because they change as it runs."""
        return {}

    def blind(self, values: Mapping[str, Array]) -> tuple[tuple[float, float], ...]:
        """Return the windows in s since the start in which its sensor moves as the law does not say."""
        return ()

    def course_std(self, values: Mapping[str, Array]) -> tuple[float, float]:
        """Return by how much its sensor's rate (rad/s) and specific force (m/s^2) may be off the law in these windows.

        Infinite where nothing is known of it: what the sensor reads then says nothing of the motion.
        """
        return np.inf, np.inf

    def acts(self, *stages: Stage) -> bool:
        """Return whether the effect acts at one of some stages."""
        return any(getattr(type(self), stage) is not getattr(Effect, stage) for stage in stages)

    @property
    def borne(self) -> bool:
        """Whether it goes along where the sensor is put on another segment: no mount's, and no seat's."""
        return self.place == "imu" and self.on_sensor and not self.acts("mount")

    @property
    def correction(self) -> Correction:
        """What is done about it in a recording that is corrected."""
        if self.fault is not None:
            return OF_FAULT[self.fault]
        if self.misplaces:
            return Correction.MOUNT
        if self.free:
            return Correction.FREE
        if self.acts("torque", "lighter"):
            return Correction.SHAPED
        if self.acts("gravity"):
            return Correction.GRAVITY
        return Correction.CLOCK if self.between_sensors else Correction.TAKEN_OUT

    @property
    def numbers(self) -> int:
        """How many numbers its parameters are."""
        return sum(p.width for p in self.parameters)

    @property
    def lawful(self) -> bool:
        """Whether its states obey a law, and are no free splines."""
        return type(self).equations is not Effect.equations

    @property
    def free(self) -> bool:
        """Whether its states are splines without a law, which take what they can of anything."""
        return bool(self.states) and not self.lawful

    def known_parts(self) -> Iterator[tuple["Effect", Parameter, Array, Array]]:
        """Yield what numbers of other effects its own (k,) stand for: effect, parameter (w,), M (w, k) and c (w,).

        The other's numbers are M x + c. Of what stands for none, nothing.
        """
        yield from ()

    def far_quicker(
        self, time: Array, beside: Mapping[str, Array], slope: Mapping[str, Array], delay: float
    ) -> "Effect":
        """Return a filter as it is where it is far quicker than a motion that is known: a delay, and little beside.

        Args:
            time: (n,) s, of the world.
            beside: gyro and accel (n, 3) that it reads beside one that only delays by `delay`, in rad/s and m/s^2.
            slope: the same by the delay, per second.
            delay: s, about which both are taken.

        Raises:
            ValueError: for what is no filter.
        """
        raise ValueError(f"{self.name}: expected a filter, got none")

    def at_moments(self, moments: Array) -> "Effect":
        """Return what begins anew at every one of some moments (k,) s, without a moment among its parameters.

        Raises:
            ValueError: for what does not begin once, at a mount.
        """
        raise ValueError(f"{self.name}: expected an effect that begins once, got another one")

    def bending(self, size: Array) -> "Effect":
        """Return the same on springs whose stiffness changes with how far they are pushed, `size` (3,) of it.

        Raises:
            ValueError: for what is not on straight springs.
        """
        raise ValueError(f"{self.name}: expected straight springs, got none")

    @property
    def straight_springs(self) -> bool:
        """Whether it is on springs that pull with how far they are pushed."""
        return False

    def clock(self, time: Jet, p: Values) -> Jet:
        """Return the world's time (n, 1) at stamps (n, 1)."""
        return time

    def aligned(self, values: Mapping[str, Array], step: float) -> dict[str, Array]:
        """Return parameters of a clock near fitted ones with which its samples lie between knots as they are stamped.

        `step` is the knots' in s. Empty for what is no clock.
        """
        return {}

    def gravity(self, gravity: Jet, p: Values) -> Jet:
        """Return the world's gravity (1, 3) m/s^2."""
        return gravity

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        """Return segment 2 on segment 1 (or a pendulum's segment on its pivot)."""
        return link

    def encoder(self, angle: Jet, scene: Scene, p: Values) -> Jet:
        """Return the angle (n, 1) rad that an encoder of the joint meets."""
        return angle

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        """Return the sensor on its segment."""
        return link

    def filtered(self, reading: Reading, scene: Scene, p: Values) -> Reading:
        """Return what is left of a reading before errors are added to it."""
        return reading

    def error(self, reading: Reading, p: Values) -> Error:
        """Return what the IMU adds to what its elements meet."""
        return Error()

    def lighter(self, p: Values) -> Jet | None:
        """Return by what all torques are to be multiplied, the inertia being as declared; None: as they are."""
        return None

    def torque(self, scene: Scene, p: Values) -> Jet | None:
        """Return the torque (n, 3) N m on the swinging segment, its axes; None: the effect is not one."""
        return None

    def equations(self, scene: Scene, p: Values) -> list[Equation]:
        """Return what the effect's states obey."""
        return []

    def follow(self, scene: Scene, p: Values) -> dict[str, Array]:
        """Return states (n, m) that follow from the motion alone, where no linear solve of the law would find them."""
        return {}

    def corrupt(
        self, time: Array, gyro: Array, accel: Array, parameters: Mapping[str, Array], rng: np.random.Generator
    ) -> tuple[Array, Array, Array]:
        """Return time (n,), gyro (n, 3) and accel (n, 3) as the samples of a plain simulation come out."""
        return time, gyro, accel

    # What follows plays an effect in MuJoCo or out of a report: numbers in, no derivatives.

    @property
    def rolled_out(self) -> bool:
        """Whether it shows only where a body is let go: it drives the equation of motion of a free swing."""
        return self.acts("torque", "lighter")

    @property
    def by_hand(self) -> bool:
        """Whether it says where a joint or a sensor goes, which no forces alone do."""
        return self.acts("joint") or (self.acts("mount") and not self.misplaces and not self.on_springs)

    @property
    def drives(self) -> bool:
        """Whether it enters the equation of motion of a free swing."""
        return self.acts("torque", "lighter", "gravity")

    @property
    def in_the_rig(self) -> bool:
        """Whether the rig that MuJoCo plays has it in: in a mount, in a joint, in the world."""
        return any(getattr(type(self), name) is not getattr(Effect, name) for name in ("on_mount", "on_rig"))

    def on_mount(self, mount: "Mount", numbers: Numbers) -> "Mount":
        """Return a mount of MuJoCo's rig with the effect in it."""
        return mount

    def on_rig(self, rig: "Rig", numbers: Numbers, weighed: bool) -> "Rig":
        """Return MuJoCo's rig with what the effect does to its joint, its bodies or its world.

        `weighed`: whether its bodies are as a recording declares them. What `numbers` leaves out is as the law's prior
        has it.
        """
        return rig

    def injected_mount(self, mount: "Mount", numbers: Numbers) -> "Mount":
        """Return a mount with the effect in it that a simulation is given; its numbers are as they are."""
        return self.on_mount(mount, numbers)

    def injected_rig(self, rig: "Rig", numbers: Numbers) -> "Rig":
        """Return the rig with the effect in it that a simulation is given; its numbers are as they are."""
        return self.on_rig(rig, numbers, weighed=False)

    def encoder_reads(self, angle: Array, numbers: Numbers) -> Array:
        """Return what an encoder reads (n,) rad of a joint that turns through `angle` (n,) rad."""
        return angle

    def of_report(self, numbers: Numbers, rng: np.random.Generator) -> Numbers:
        """Return numbers of the law's own parameters for those that a report names; what nobody told is drawn."""
        return numbers


__all__ = [
    "Change", "Effect", "Equation", "Error", "Found", "Numbers", "Parameter", "Place", "Reading", "Scene", "Setting",
    "Stage", "State", "Values",
]  # fmt: skip
