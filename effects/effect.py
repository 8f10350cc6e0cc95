"""What an effect is: one physical law, its parameters, and where in the chain of a measurement it acts."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from imubench.arrays import Array
from imubench.jets import Jet
from imubench.links import Link, Motion

Place = Literal["imu", "joint", "body", "world"]


@dataclass(frozen=True)
class Parameter:
    """One parameter of a law: its shape, unit, and how large it may plausibly be."""

    name: str
    shape: tuple[int, ...]  # () a number, (3,) an array
    unit: str
    std: float  # of the prior about `start`, in `unit`
    start: float = 0.0  # where a fit begins, and the prior's centre
    log: bool = False  # positive: the fit moves its logarithm, and `std` is that of the logarithm

    @property
    def width(self) -> int:
        """How many numbers it is."""
        return int(np.prod(self.shape, dtype=int))


@dataclass(frozen=True)
class Reading:
    """What the sensing elements of one IMU meet, in sensor axes."""

    gyro: Jet  # (n, 3) rad/s
    accel: Jet  # (n, 3) m/s^2, specific force
    time: Array  # (n,) s since the recording's start


@dataclass(frozen=True)
class Error:
    """What an effect adds to a reading; errors act side by side on the true signal."""

    gyro: Jet | None = None  # (n, 3) rad/s
    accel: Jet | None = None  # (n, 3) m/s^2


@dataclass(frozen=True)
class Scene:
    """Where the rig is at some times, as an effect may ask for it; (n, m) everywhere."""

    time: Array  # (n,) s since the recording's start
    segment: Motion  # of the segment that the effect's sensor sits on (the child's, at a joint)
    angle: Jet | None = None  # (n, 1) rad, hinge angle or pendulum swing
    angle_rate: Jet | None = None  # rad/s
    angle_accel: Jet | None = None  # rad/s^2
    state: Callable[[str, int], Jet] | None = None  # the effect's own splines and their derivatives
    mount: Link | None = None  # sensor on segment, before the effect


@dataclass(frozen=True)
class Equation:
    """A law that a state obeys: its residual (n, m) is zero up to `std`."""

    name: str
    residual: Jet
    std: float


@dataclass(frozen=True)
class State:
    """Numbers that follow a law over time, a spline in the fit."""

    name: str
    width: int
    std: float  # their plausible size, for a prior


Values = Mapping[str, Jet]


class Effect:
    """One left-out law. A subclass names it and overrides the one stage where it acts.

    Everything is written on `Jet`, so the same lines simulate (no derivatives) and fit (exact Jacobian).
    """

    name: ClassVar[str]
    place: ClassVar[Place]
    law: ClassVar[str]  # one line, with its symbols
    rigs: ClassVar[tuple[str, ...]] = ("hinge", "pendulum", "free")
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    states: ClassVar[tuple[State, ...]] = ()

    def clock(self, time: Jet, p: Values) -> Jet:
        """Return the world's time (n, 1) at stamps (n, 1)."""
        return time

    def joint(self, link: Link, scene: Scene, p: Values) -> Link:
        """Return segment 2 on segment 1 (or a pendulum's segment on its pivot)."""
        return link

    def mount(self, link: Link, scene: Scene, p: Values) -> Link:
        """Return the sensor on its segment."""
        return link

    def filtered(self, reading: Reading, scene: Scene, p: Values) -> Reading:
        """Return what is left of a reading before errors are added to it."""
        return reading

    def error(self, reading: Reading, p: Values) -> Error:
        """Return what the IMU adds to what its elements meet."""
        return Error()

    def torque(self, scene: Scene, p: Values) -> Jet | None:
        """Return the torque (n, 3) N m on the swinging segment, its axes; None: the effect is not one."""
        return None

    def equations(self, scene: Scene, p: Values) -> list[Equation]:
        """Return what the effect's states obey."""
        return []
