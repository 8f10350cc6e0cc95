"""What an effect is: one physical law, its parameters, and where in the chain of a measurement it acts."""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.jets import Jet
from imubench.links import Link, Motion
from imubench.models.tree import Tree
from imubench.recording import Imu, Recording

Place = Literal["imu", "joint", "body", "world"]


@dataclass(frozen=True)
class Parameter:
    """One parameter of a law: its shape, unit, and how large it may plausibly be."""

    name: str
    shape: tuple[int, ...]  # () a number, (3,) an array
    unit: str
    std: float  # of the prior about `start`, in `unit`
    start: float | tuple[float, ...] = 0.0  # where a fit begins, and the prior's centre
    log: bool = False  # positive: the fit moves its logarithm, and `std` is that of the logarithm
    sided: bool = False  # nature knows it only at or above zero, though the fit may go below
    reported: bool = True  # False: the law needs it, the table of effects does not name it

    @property
    def width(self) -> int:
        """How many numbers it is."""
        return int(np.prod(self.shape, dtype=int))

    @property
    def centre(self) -> Array:
        """The prior's centre (k,) in the fit's variable."""
        start = np.broadcast_to(np.asarray(self.start, dtype=float).reshape(-1), (self.width,))
        return np.log(start) if self.log else start.copy()


@dataclass(frozen=True)
class Found:
    """A parameter that is read off the raw samples or the fitted states, not fitted itself."""

    name: str
    shape: tuple[int | None, ...]  # None: any number of them
    unit: str


@dataclass(frozen=True)
class Change:
    """How far the numbers of an effect go from one recording of a sensor to the next, as standard deviations."""

    std: float = 0.0  # in the number's unit
    share: float = 0.0  # of the number

    def of(self, value: Array) -> Array:
        """Return the standard deviations (k,) of numbers (k,)."""
        return np.asarray(np.hypot(self.std, self.share * value))


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
Setting = float | str | tuple[str, ...]


class Effect:
    """One left-out law. A subclass names it and overrides the stage where it acts.

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
    scales_angle: ClassVar[bool] = False  # whether with other numbers a joint that turns faster looks the same
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
