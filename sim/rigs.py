"""Rigs as numbers: what can be set without editing an MJCF file."""

from dataclasses import dataclass, field, replace
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array, frozen, frozen_quaternion
from imubench.errors import InputError, unknown
from imubench.models import is_rig, known_rigs, mjcf
from imubench.models.tree import Tree, rig_spec, rig_tree
from imubench.recording import STANDARD_GRAVITY, positive
from imubench.sim.joints import Play, Stop
from imubench.sim.signals import Signal

HEAVIEST = 0.7  # of a mount's gyration radius k: with its com so far off, m (k^2 - c^2), twice, and m k^2 are a body's


@dataclass(frozen=True)
class Spring:
    """Three springs and dampers along (or about) three axes: x'' + 2 z w x' + w^2 x = drive, w = 2 pi f."""

    frequency: Array  # (3,) Hz, undamped
    damping_ratio: Array  # (3,)

    def __post_init__(self) -> None:
        for key in ("frequency", "damping_ratio"):
            object.__setattr__(self, key, frozen(getattr(self, key), (3,), f"spring.{key}"))
        if (self.frequency <= 0).any() or (self.damping_ratio < 0).any():
            raise InputError(
                "spring: expected frequencies > 0 Hz and damping ratios >= 0, got "
                f"{self.frequency.tolist()} and {self.damping_ratio.tolist()}"
            )


def springs(frequency: ArrayLike, damping_ratio: ArrayLike) -> Spring:
    """Return springs from three numbers each, or from one that stands for all three."""
    return Spring(*(np.broadcast_to(np.asarray(x, dtype=float), (3,)) for x in (frequency, damping_ratio)))


@dataclass(frozen=True)
class Slip:
    """A sensor that slips once: from `time` s on it sits elsewhere; the change takes a fifth of a second."""

    time: float  # s, of its start
    translation: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m, segment axes
    rotation: Array = field(default_factory=lambda: np.zeros(3))  # (3,) rad, sensor axes: q = q_mount exp(rotation)

    def __post_init__(self) -> None:
        for key in ("translation", "rotation"):
            object.__setattr__(self, key, frozen(getattr(self, key), (3,), f"slip.{key}"))


@dataclass(frozen=True)
class Mount:
    """Where an IMU sits on its segment, and on what it hangs.

    A sprung mount moves by `translation` along the segment's axes and turns by `rotation`
    about the sensor's axes, around a pivot that lies `-lever` from the sensing point. The
    moment of inertia about that pivot is mass * gyration^2, the same about every axis; `com`
    is the centre of mass seen from the pivot. The pose is that of the unloaded springs.
    """

    position: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m, segment frame
    quaternion: Array = field(default_factory=lambda: np.array([1.0, 0, 0, 0]))  # sensor -> segment
    translation: Spring | None = None  # along segment axes
    rotation: Spring | None = None  # about sensor axes
    mass: float = 0.016  # kg
    gyration: float = 0.015  # m
    com: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m, sensor axes, from the pivot
    lever: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m, sensor axes, pivot to sensing point
    path: tuple[Signal, Signal, Signal] | None = None  # m, segment axes: the sensor slides like this, whatever happens
    path_felt: bool = True  # False: the accelerometer does not feel the sliding, as some papers have it
    slip: Slip | None = None
    slide: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m/rad, segment axes: with the angle of the joint
    twist: Array = field(default_factory=lambda: np.zeros(3))  # (3,) rad/rad, sensor axes: q = q_mount exp(twist angle)

    def __post_init__(self) -> None:
        for key in ("position", "com", "lever", "slide", "twist"):
            object.__setattr__(self, key, frozen(getattr(self, key), (3,), f"mount.{key}"))
        object.__setattr__(self, "quaternion", frozen_quaternion(self.quaternion, "mount.quaternion"))
        positive(self.mass, "mount.mass")
        positive(self.gyration, "mount.gyration")
        if np.linalg.norm(self.com) >= HEAVIEST * self.gyration:
            raise InputError(
                f"mount.com: expected less than {HEAVIEST * self.gyration:.3g} m from the pivot, "
                f"{HEAVIEST:g} of the gyration radius, got {np.linalg.norm(self.com):g} m"
            )
        if self.path is not None and self.sprung:
            raise InputError("mount: expected springs or a prescribed path, got both")

    @property
    def sprung(self) -> bool:
        """True if the sensor hangs on springs."""
        return self.translation is not None or self.rotation is not None

    @property
    def slides(self) -> bool:
        """True if the sensor moves on its segment as it is told: along a path, by a slip, or with the joint."""
        return self.path is not None or self.slip is not None or bool(self.slide.any() or self.twist.any())

    @property
    def moves(self) -> bool:
        """True if the sensor can move on its segment, on springs or as it is told."""
        return self.sprung or self.slides


@dataclass(frozen=True)
class Segment:
    """Mass and geometry of a segment without its IMU."""

    mass: float  # kg
    com: Array  # (3,) m, segment frame
    inertia: Array  # (3,) kg m^2 about the com, segment axes
    length: float = 0.2  # m, for pictures

    def __post_init__(self) -> None:
        positive(self.mass, "segment.mass")
        positive(self.length, "segment.length")
        object.__setattr__(self, "com", frozen(self.com, (3,), "segment.com"))
        object.__setattr__(self, "inertia", frozen(self.inertia, (3,), "segment.inertia"))
        a, b, c = sorted(self.inertia)
        if a <= 0 or a + b < c * (1 - 1e-9):
            raise InputError(
                f"segment.inertia: expected three moments that a body can have, got {self.inertia.tolist()}"
            )


@dataclass(frozen=True)
class Rig:
    """One rig, ready to be compiled into a MuJoCo model."""

    family: str  # a rig of `imubench list rigs`
    mounts: tuple[Mount, ...]  # imu1 on segment 1, imu2 on segment 2
    segments: tuple[Segment, ...]
    base: Literal["free", "fixed"] = "free"  # fixed: its first segment is clamped
    base_quaternion: Array = field(default_factory=lambda: np.array([1.0, 0, 0, 0]))  # segment 1 -> world, if fixed
    pivot_moves: bool = False  # pendulum only: its pivot goes where the motion's position says
    locked_at: float | None = None  # rad; the hinge angle at which a screw holds the joint
    damping: float = 0.0  # N m s/rad, viscous friction of the joint
    dry_friction: float = 0.0  # N m
    drag: float = 0.0  # N m s^2/rad^2, torque -drag |w| w
    stiffness: float = 0.0  # N m/rad, of a spring across the joint
    spring_angle: float = 0.0  # rad, at which that is slack
    spring_conserves: bool = False  # pendulum only: the spring acts along the gradient of its angle; `sim.ball`
    stop: Stop | None = None
    inertia_scale: float = 1.0  # m l / I of the swinging segment is so many times its segment's, its weight the same
    coupling: Array = field(default_factory=lambda: np.zeros(2))  # (2,) rad/rad, hinge only; see `sim.joints`
    centre: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m/rad, segment 1's axes, hinge only
    play: Play | None = None  # hinge only
    gravity: float = STANDARD_GRAVITY  # m/s^2

    def __post_init__(self) -> None:
        if not is_rig(self.family):
            raise unknown("rig", self.family, known_rigs())
        tree, expected = self.tree, len(self.tree.names)
        if len(self.segments) != expected or not 1 <= len(self.mounts) <= expected:
            raise InputError(
                f"rig {self.family}: expected {expected} segments and one mount each, got "
                f"{len(self.segments)} and {len(self.mounts)}"
            )
        if (self.base == "fixed" and not tree.clamps) or (self.locked_at is not None and tree.hinge is None):
            raise InputError(f"rig {self.family}: expected a hinge for base = 'fixed' or a screw, got none")
        object.__setattr__(self, "base_quaternion", frozen_quaternion(self.base_quaternion, "base_quaternion"))
        if self.pivot_moves and tree.ball is None:
            raise InputError(f"rig {self.family}: expected a pendulum for a pivot that moves, got none")
        if tree.loose and (self.drag or self.stiffness or self.stop is not None):
            raise InputError(f"rig {self.family}: expected a joint for drag, a spring across it or a stop, got none")
        for key in ("damping", "dry_friction", "drag", "gravity"):
            positive(getattr(self, key), f"rig.{key}", or_zero=True)
        positive(self.inertia_scale, "rig.inertia_scale")
        for key, width in (("coupling", 2), ("centre", 3)):
            object.__setattr__(self, key, frozen(getattr(self, key), (width,), f"rig.{key}"))
        if tree.hinge is None and (self.wanders or self.play is not None):
            raise InputError(f"rig {self.family}: expected a hinge for coupling, a moving centre or play, got none")
        if self.locked_at is not None and (self.wanders or self.play is not None or self.stop is not None):
            raise InputError(f"rig {self.family}: expected a screw or what a joint does beside turning, got both")

    @property
    def tree(self) -> Tree:
        """Its segments, joints and IMUs, as its file has them."""
        return rig_tree(self.family)

    @property
    def clamped(self) -> bool:
        """Whether its first segment is bolted to the world."""
        return self.tree.clamps and self.base == "fixed"

    @property
    def sprung(self) -> bool:
        """True if any sensor hangs on springs."""
        return any(mount.sprung for mount in self.mounts)

    @property
    def follows(self) -> bool:
        """True if something moves by forces where the joints are driven: a sensor on springs, a limb with play."""
        return self.sprung or self.loose is not None

    @property
    def loose(self) -> Play | None:
        """The play, if it moves by forces and not as it is told."""
        return self.play if self.play is not None and self.play.path is None else None

    @property
    def wanders(self) -> bool:
        """True if the hinge's axis or centre moves with its angle."""
        return bool(self.coupling.any() or self.centre.any())

    @property
    def spring_columns(self) -> list[slice]:
        """Each mount's own among the joints that follow (`follows`), three to a spring; none of a rigid one.

        The play, if there is any, comes between the first mount and the second.
        """
        counts = [3 * sum(s is not None for s in (m.translation, m.rotation)) for m in self.mounts]
        starts = np.cumsum([0, *counts[:-1]])
        starts[1:] += self.loose is not None
        return [slice(int(a), int(a) + n) for a, n in zip(starts, counts, strict=True)]

    @property
    def play_column(self) -> int:
        """Where the play is among the joints that follow."""
        return self.spring_columns[0].stop


def inertia_about(rig: Rig, axis: Array) -> float:
    """Return the inertia of the swinging segment in kg m^2 about a unit vector (3,) of its axes, through the joint."""
    segment = rig.segments[-1]
    c = segment.com
    own = float(axis @ (segment.inertia * axis) + segment.mass * (c @ c - (c @ axis) ** 2))
    return own / rig.inertia_scale


def rod(mass: float, start: ArrayLike, end: ArrayLike, radius: float) -> Segment:
    """Return a cylinder of `mass` kg from `start` to `end` (m, segment frame, along one axis)."""
    a, b = np.array(start), np.array(end)
    length = float(np.linalg.norm(b - a))
    along, across = mass * radius**2 / 2, mass * (3 * radius**2 + length**2) / 12
    inertia = np.where(np.abs(b - a) > length / 2, along, across)
    return Segment(mass, (a + b) / 2, inertia, float(max(np.linalg.norm(a), np.linalg.norm(b))))


@cache
def _standard(family: str, text: str) -> Rig:
    """Return a rig as its file has it, which holds `text` now: segments with its inertia, or cylinders as capsules."""
    spec, tree = rig_spec(family), rig_tree(family)
    segments = []
    for body in (spec.body(name) for name in tree.names):
        geom = body.geoms[0]
        if body.explicitinertial:
            ends = np.asarray(geom.fromto).reshape(2, 3)
            length = {"length": float(np.linalg.norm(ends, axis=1).max())} if np.isfinite(ends).all() else {}
            segments.append(Segment(float(body.mass), body.ipos, body.inertia, **length))
        else:
            segments.append(rod(float(geom.mass), geom.fromto[:3], geom.fromto[3:], float(geom.size[0])))
    sites = (tree.sites[imu] for imu in tree.imus)
    mounts = tuple(Mount(np.array(site.position), np.array(site.quaternion)) for site in sites)
    return Rig(family, mounts, tuple(segments))


def standard_rig(family: str, **changes: object) -> Rig:
    """Return a rig as its file has it, with changes.

    Args:
        family: one of `imubench list rigs`.
        **changes: fields of `Rig`.
    """
    return replace(_standard(family, mjcf(family)), **changes)  # type: ignore[arg-type]


def hinge(**changes: object) -> Rig:
    """Return the standard hinge rig: two 20 cm segments of 0.25 kg with an IMU 10 cm from the joint on each."""
    return standard_rig("hinge", **changes)


def pendulum(**changes: object) -> Rig:
    """Return the standard pendulum: a 40 cm limb of 5 kg, the pivot at r = (-60, 20, 200) mm from the IMU.

    Source: Garcia de Villa et al., section IV-A.
    """
    return standard_rig("pendulum", **changes)


def free(**changes: object) -> Rig:
    """Return the free body with an IMU in its origin."""
    return standard_rig("free", **changes)


def random_hinge(rng: np.random.Generator, **changes: object) -> Rig:
    """Return a hinge rig with random mounts, masses and lengths, as a person would build it.

    Mounts sit 4 to 25 cm from the joint and up to 4 cm off the segment, turned at random.
    """
    from imubench import rotations

    def mount(side: float) -> Mount:
        off = np.array([side * rng.uniform(0.04, 0.25), *rng.uniform(-0.04, 0.04, size=2)])
        return Mount(position=off, quaternion=rotations.random(rng))

    def segment(side: float) -> Segment:
        return rod(
            rng.uniform(0.1, 2.0), (side * 0.01, 0, 0), (side * rng.uniform(0.1, 0.4), 0, 0), rng.uniform(0.01, 0.05)
        )

    return hinge(mounts=(mount(-1), mount(1)), segments=(segment(-1), segment(1)), **changes)
