"""What a laboratory, or the simulator, hands over: measurements and declared facts, never truth."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array, frozen, frozen_quaternion, frozen_time
from imubench.displays import Displayed, Summarised
from imubench.errors import InputError, unknown
from imubench.models import imu_names, is_rig, known_rigs
from imubench.models.tree import Tree, rig_tree

OWN_IMUS = ("imu1", "imu2")  # of a rig of its owner's own

STANDARD_GRAVITY = 9.81  # m/s^2, the world's unless a recording says otherwise


@dataclass(frozen=True, repr=False)
class Imu(Summarised):
    """One IMU's samples on its own clock, and what its owner declares about it.

    Raises `InputError` when arrays disagree in length, time does not increase, a value is
    not finite, or the mount quaternion is not a unit.
    """

    name: str
    time: Array  # (n,) s, own clock
    gyro: Array  # (n, 3) rad/s, sensor axes
    accel: Array  # (n, 3) m/s^2, specific force in sensor axes
    rate: float  # Hz, nominal
    gyro_noise_std: float | None = None  # rad/s per sample; None: to be estimated
    accel_noise_std: float | None = None  # m/s^2 per sample
    gyro_range: float | None = None  # rad/s
    accel_range: float | None = None  # m/s^2
    mount_position: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m, segment frame
    mount_quaternion: Array = field(default_factory=lambda: np.array([1.0, 0, 0, 0]))  # sensor -> segment
    mount_position_std: float | None = None  # m; None: unknown
    mount_rotation_std: float | None = None  # rad
    profile: str | None = None  # of an IMU like this one: it has told the noise where its owner did not

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "time", frozen_time(self.time, f"{self.name}.time"))
        n = self.time.size
        put(self, "gyro", frozen(self.gyro, (n, 3), f"{self.name}.gyro"))
        put(self, "accel", frozen(self.accel, (n, 3), f"{self.name}.accel"))
        put(self, "mount_position", frozen(self.mount_position, (3,), f"{self.name}.mount_position"))
        put(self, "mount_quaternion", frozen_quaternion(self.mount_quaternion, f"{self.name}.mount_quaternion"))
        positive(self.rate, f"{self.name}.rate")
        for key in (
            "gyro_noise_std", "accel_noise_std", "gyro_range", "accel_range",
            "mount_position_std", "mount_rotation_std",
        ):  # fmt: skip
            if getattr(self, key) is not None:
                positive(getattr(self, key), f"{self.name}.{key}", or_zero=key.endswith("_std"))


@dataclass(frozen=True, repr=False)
class Encoder(Summarised):
    """A measured joint angle, a sensor like any other."""

    joint: str
    time: Array  # (n,) s
    angle: Array  # (n,) rad, as read
    angle_noise_std: float | None = None  # rad
    zero: float = 0.0  # rad, added to the reading to give the joint angle

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", frozen_time(self.time, f"encoder {self.joint}.time"))
        object.__setattr__(self, "angle", frozen(self.angle, (self.time.size,), f"encoder {self.joint}.angle"))


@dataclass(frozen=True, repr=False)
class Pose(Summarised):
    """A measured pose of a segment, used as a sensor; NaN where it was not seen."""

    segment: str
    time: Array  # (n,) s
    position: Array | None = None  # (n, 3) m, world
    quaternion: Array | None = None  # (n, 4) segment -> world
    position_noise_std: float | None = None  # m
    rotation_noise_std: float | None = None  # rad

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", frozen_time(self.time, f"pose {self.segment}.time"))
        for key, width in (("position", 3), ("quaternion", 4)):
            if getattr(self, key) is not None:
                shape, name = (self.time.size, width), f"pose {self.segment}.{key}"
                object.__setattr__(self, key, frozen(getattr(self, key), shape, name, finite=False))
        if self.position is None and self.quaternion is None:
            raise InputError(f"pose {self.segment}: expected a position or a quaternion, got neither")


@dataclass(frozen=True)
class Body:
    """What the model believes about the swinging segment."""

    mass: float  # kg
    com: Array  # (3,) m, segment frame
    inertia: Array  # (3,) kg m^2 about the com, segment axes

    def __post_init__(self) -> None:
        positive(self.mass, "body.mass")
        object.__setattr__(self, "com", frozen(self.com, (3,), "body.com"))
        object.__setattr__(self, "inertia", frozen(self.inertia, (3,), "body.inertia"))
        if (self.inertia <= 0).any():
            raise InputError(f"body.inertia: expected three positive numbers, got {self.inertia.tolist()}")


@dataclass(frozen=True, repr=False)
class Recording(Summarised, Displayed):
    """Everything an estimator or the diagnosis may see of one experiment."""

    name: str
    rig: str  # one of `imubench list rigs`, or a path to an MJCF file
    imus: tuple[Imu, ...] = ()
    motion: Literal["hand", "free"] = "hand"  # free: no outside force inside the free swings
    gravity: float = STANDARD_GRAVITY  # m/s^2
    base: Literal["free", "fixed"] = "free"
    base_quaternion: Array = field(default_factory=lambda: np.array([1.0, 0, 0, 0]))  # segment 1 -> world
    encoders: tuple[Encoder, ...] = ()
    poses: tuple[Pose, ...] = ()
    free_swings: tuple[tuple[float, float], ...] = ()  # (start, end) s
    body: Body | None = None

    def __post_init__(self) -> None:
        if not self.name.isprintable():
            raise InputError(f"name: expected text without control characters, got '{self.name}'")
        if not is_rig(self.rig) and not self.rig.endswith(".xml"):
            raise unknown("rig", self.rig, known_rigs())
        for value, key, known in ((self.motion, "motion", ("hand", "free")), (self.base, "base", ("free", "fixed"))):
            if value not in known:
                raise unknown(key, value, known)
        object.__setattr__(self, "base_quaternion", frozen_quaternion(self.base_quaternion, "base_quaternion"))
        positive(self.gravity, "gravity", or_zero=True)
        if not (self.imus or self.encoders or self.poses):
            raise InputError(f"{self.name}: expected at least one imu, encoder or pose, got none")
        names = [imu.name for imu in self.imus]
        allowed = imu_names(self.rig) if is_rig(self.rig) else OWN_IMUS
        for name in names:
            if name not in allowed:
                raise unknown(f"imu on rig {self.rig}", name, allowed)
        if len(set(names)) != len(names):
            raise InputError(f"{self.name}: expected each imu once, got {', '.join(names)}")
        _check_overlap(self.imus)
        for start, end in self.free_swings:
            if not end > start:
                raise InputError(f"free_swing: expected end after start, got {start:g} s to {end:g} s")

    @property
    def tree(self) -> Tree:
        """The rig's segments, joints and IMUs; without any where the rig is its owner's own."""
        return rig_tree(self.rig)

    @property
    def clamped(self) -> bool:
        """Whether the first segment is bolted to the world, on the declared base."""
        return self.tree.clamps and self.base == "fixed"

    @property
    def moving(self) -> tuple[Imu, ...]:
        """The IMUs whose segment can move: a clamped one cannot."""
        return tuple(imu for imu in self.imus if not (self.clamped and self.carrier(imu.name) == self.tree.names[0]))

    def carrier(self, imu: str) -> str:
        """Return the name of the segment that carries an IMU; by its number on a rig of its owner's own."""
        return self.tree.carriers.get(imu) or imu.replace("imu", "segment")

    def imu(self, name: str) -> Imu:
        """Return the IMU of that name; `InputError` names the known ones."""
        for imu in self.imus:
            if imu.name == name:
                return imu
        raise unknown("imu", name, [i.name for i in self.imus])


def _check_overlap(imus: Sequence[Imu]) -> None:
    for first, second in pairwise(imus):
        start = max(first.time[0], second.time[0])
        end = min(first.time[-1], second.time[-1])
        if not end > start:
            raise InputError(
                f"{first.name} and {second.name}: expected recordings that overlap in time, got "
                f"{first.time[0]:g} to {first.time[-1]:g} s and {second.time[0]:g} to {second.time[-1]:g} s"
            )


def span_of(recording: Recording) -> tuple[float, float]:
    """Return the first and the last stamp of all sensors in s."""
    stamps = [i.time for i in recording.imus] + [e.time for e in recording.encoders]
    stamps += [p.time for p in recording.poses]
    return min(float(t[0]) for t in stamps), max(float(t[-1]) for t in stamps)


def require_known_rig(recording: Recording, what: str) -> None:
    """Raise `InputError` where a recording is of a rig of its owner's own, which `what` does not support yet."""
    if not is_rig(recording.rig):
        raise InputError(
            f"{recording.name}, key 'rig': expected {', '.join(known_rigs())} for {what}, got '{recording.rig}'; "
            "a file beside a recording is not looked into: a package can offer it as a rig (docs/your-rig.md)"
        )


def positive(value: ArrayLike, name: str, or_zero: bool = False) -> None:
    """Raise `InputError` unless `value` is a finite number above (or at) zero."""
    ok = isinstance(value, int | float | np.floating) and not isinstance(value, bool) and np.isfinite(value)
    if not ok or value < 0 or (value == 0 and not or_zero):  # type: ignore[operator]
        raise InputError(f"{name}: expected a number {'>= 0' if or_zero else '> 0'}, got {value!r}")
