"""Rig families with ranges of geometry: what a rig of a dataset is drawn from.

Rigs are made by people: segments are cylinders along their axis, IMUs sit `mount_distance` from the joint along the
segment and up to `mount_offset` off its middle, turned anyhow or nearly along the segment.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.dataset.ranges import Range, check_keys, chosen, located, number, parse_range, weight
from imubench.errors import InputError
from imubench.models import RIG_FILES, known_rigs
from imubench.models.tree import Tree, rig_tree
from imubench.sim.injected import sprung_mount
from imubench.sim.rigs import Mount, Rig, Segment, rod, standard_rig

NUMBERS: Mapping[str, tuple[object, float, bool]] = {  # key -> default, lower limit, whether that is excluded
    "mount_distance": ([0.04, 0.25], 0.0, False),  # m from the joint; any direction on the free body
    "mount_offset": ([-0.04, 0.04], -np.inf, False),  # m, across the segment
    "segment_length": ([0.1, 0.4], 0.02, True),  # m
    "segment_mass": ([0.1, 2.0], 0.0, True),  # kg
    "segment_radius": ([0.01, 0.05], 0.0, True),  # m
    "gravity": (9.81, 0.0, False),  # m/s^2, of the rig's place, and declared so
}
SPRING_NUMBERS: Mapping[str, tuple[object, float, bool]] = {
    "frequency": ({"low": 5.0, "high": 25.0, "scale": "log"}, 0.5, False),  # Hz
    "damping_ratio": ([0.05, 0.3], 0.0, False),
    "com": ([-0.004, 0.004], -np.inf, False),  # m
    "lever": ([-0.02, 0.02], -np.inf, False),  # m
}
SIZES = tuple(key for key in NUMBERS if key != "gravity")
"""What is drawn of our own rigs; a package's is as its file has it."""
KEYS = ("family", "weight", "base", "mount_rotation", "soft", "rocking", "soft_probability", "rocking_probability")
GYRATION = 0.015  # m, of an IMU in its box about its pivot
FARTHEST = 0.006  # m, of a com along each axis: a mount's body can be so however the three come
FASTEST = 200.0  # Hz, of a spring: its integration takes 200 steps a period


@dataclass(frozen=True)
class Springs:
    """One kind of sprung mount and how often it comes, an IMU at a time."""

    probability: float
    ranges: Mapping[str, Range]


@dataclass(frozen=True)
class RigRange:
    """One `[[rig]]` of a spec."""

    family: str
    weight: float
    base: str  # fixed: only of a rig whose first segment can be clamped
    ranges: Mapping[str, Range]
    mount_rotation: Range | None  # rad, about each axis, from the segment's axes; None: anyhow
    soft: Springs
    rocking: Springs

    @property
    def as_built(self) -> bool:
        """Whether its sizes and mounts are those of its file: it is a package's."""
        return self.family not in RIG_FILES

    @property
    def tree(self) -> Tree:
        """The family's segments, joints and IMUs."""
        return rig_tree(self.family)


@dataclass(frozen=True)
class DrawnRig:
    """A rig with rigid mounts, and the springs under them as effects."""

    rig: Rig
    springs: tuple[dict[str, Any], ...]  # {"effect", "at", "parameters"}

    @property
    def loaded(self) -> Rig:
        """The rig with its mounts on their springs."""
        mounts = (sprung_mount(m, f"imu{i + 1}", self.springs) for i, m in enumerate(self.rig.mounts))
        return replace(self.rig, mounts=tuple(mounts))


def parse_rig(table: Mapping[str, Any], where: str) -> RigRange:
    """Return one `[[rig]]`; `InputError` for an unknown key, a number out of bounds, ranges that make no rig."""
    check_keys(table, (*KEYS, *NUMBERS), where)
    family = chosen(table.get("family"), f"{where}.family", tuple(known_rigs()))
    base = chosen(table.get("base", "free"), f"{where}.base", ("free", "fixed"))
    if base == "fixed" and not rig_tree(family).clamps:
        raise InputError(f"{where}.base: expected a hinge for base = 'fixed', got {family}")
    if family not in RIG_FILES:
        for key in (*SIZES, "mount_rotation"):
            if key in table:
                raise InputError(f"{where}.{key}: expected none of the rig {family}, whose file says it")
    turned = table.get("mount_rotation", "any")
    found = RigRange(
        family,
        weight(table, where),
        base,
        _ranges(table, NUMBERS, where),
        None if turned == "any" else parse_range(turned, f"{where}.mount_rotation"),
        _springs(table, "soft", ("frequency", "damping_ratio"), where),
        _springs(table, "rocking", tuple(SPRING_NUMBERS), where),
    )
    _check_makes_rigs(found, where)
    return found


def _ranges(table: Mapping[str, Any], known: Mapping[str, tuple[object, float, bool]], where: str) -> dict[str, Range]:
    return {
        key: parse_range(table.get(key, default), f"{where}.{key}", low, open_low=excluded)
        for key, (default, low, excluded) in known.items()
    }


def _springs(table: Mapping[str, Any], kind: str, keys: tuple[str, ...], where: str) -> Springs:
    given = table.get(kind, {})
    if not isinstance(given, dict):
        raise InputError(f"{where}.{kind}: expected a table, got {given!r}")
    check_keys(given, keys, f"{where}.{kind}")
    probability = number(table.get(f"{kind}_probability", float(kind in table)), f"{where}.{kind}_probability", high=1)
    ranges = _ranges(given, {key: SPRING_NUMBERS[key] for key in keys}, f"{where}.{kind}")
    if "frequency" in given:
        parse_range(given["frequency"], f"{where}.{kind}.frequency", high=FASTEST)
    if "com" in given:
        parse_range(given["com"], f"{where}.{kind}.com", -FARTHEST, FARTHEST)
    return Springs(probability, ranges)


def _check_makes_rigs(ranges: RigRange, where: str) -> None:
    """Raise `InputError` where a corner of the ranges is no rig: extremes are where numbers stop to fit."""
    if (
        not ranges.tree.loose
        and not ranges.as_built
        and ranges.ranges["mount_distance"].low > ranges.ranges["segment_length"].high
    ):
        near, far = ranges.ranges["mount_distance"].low, ranges.ranges["segment_length"].high
        raise InputError(
            f"{where}.mount_distance: expected mounts that a segment of at most {far:g} m can hold, "
            f"got {near:g} m and more from the joint"
        )
    for seed in range(20):
        with located(where):
            draw_rig(ranges, np.random.default_rng(seed))


def draw_rig(ranges: RigRange, rng: np.random.Generator) -> DrawnRig:
    """Return a rig; `InputError` where the numbers drawn make none."""
    shapes, mounts_rng, springs_rng, base_rng = rng.spawn(4)
    changes = {} if ranges.as_built else _sizes(ranges, shapes, mounts_rng)
    if ranges.base == "fixed":
        changes |= {"base": "fixed", "base_quaternion": rotations.random(base_rng)}
    rig = standard_rig(ranges.family, gravity=ranges.ranges["gravity"].one(base_rng), **changes)
    springs = [s for imu in ranges.tree.imus for s in _drawn_springs(ranges, imu, springs_rng)]
    drawn = DrawnRig(rig, tuple(springs))
    _ = drawn.loaded  # raises where a mount cannot be
    return drawn


def _sizes(ranges: RigRange, shapes: np.random.Generator, mounts: np.random.Generator) -> dict[str, Any]:
    """Return the segments and mounts of a rig."""
    directions = [None if s.along is None else np.array(s.along) for s in ranges.tree.segments]
    bodies = [_segment(ranges, along, shapes) for along in directions]
    placed = (_mount(ranges, along, reach, mounts) for along, (_, reach) in zip(directions, bodies, strict=True))
    return {"segments": tuple(body for body, _ in bodies), "mounts": tuple(placed)}


def _segment(ranges: RigRange, along: Array | None, rng: np.random.Generator) -> tuple[Segment, float]:
    """Return a cylinder from 1 cm beside the joint to its end, and where that end is in m; about the origin without."""
    length, mass, radius = (ranges.ranges[f"segment_{k}"].one(rng) for k in ("length", "mass", "radius"))
    if along is None:
        return rod(mass, (-length / 2, 0, 0), (length / 2, 0, 0), radius), np.inf
    return rod(mass, 0.01 * along, length * along, radius), length


def _mount(ranges: RigRange, side: Array | None, reach: float, rng: np.random.Generator) -> Mount:
    """Return where an IMU sits; one that would sit beyond its segment's end sits on the end."""
    along = min(ranges.ranges["mount_distance"].one(rng), reach)
    across: Array = ranges.ranges["mount_offset"].draw(rng, (2,))
    if side is None:
        direction = rng.standard_normal(3)
        position = along * direction / np.linalg.norm(direction)
    else:
        axis = int(np.argmax(np.abs(side)))
        position = np.insert(across, axis, side[axis] * along)
    if ranges.mount_rotation is None:
        return Mount(position, rotations.random(rng))
    return Mount(position, rotations.exp(ranges.mount_rotation.draw(rng, (3,))))


def _drawn_springs(ranges: RigRange, at: str, rng: np.random.Generator) -> list[dict[str, Any]]:
    drawn = []
    soft, rocking = rng.spawn(2)
    if soft.random() < ranges.soft.probability:
        r = ranges.soft.ranges
        values = {"frequency": r["frequency"].draw(soft, (3,)), "damping_ratio": r["damping_ratio"].one(soft)}
        drawn.append({"effect": "soft_mount", "at": at, "parameters": values})
    if rocking.random() < ranges.rocking.probability:
        values = {key: ranges.rocking.ranges[key].draw(rocking, (3,)) for key in SPRING_NUMBERS}
        drawn.append({"effect": "rocking_mount", "at": at, "parameters": values | {"gyration": GYRATION}})
    return drawn


def pick(weights: Sequence[float], rng: np.random.Generator) -> int:
    """Return an index, each as often as its weight says."""
    edges = np.cumsum(weights) / np.sum(weights)
    return min(int(np.searchsorted(edges, rng.random(), side="right")), len(edges) - 1)
