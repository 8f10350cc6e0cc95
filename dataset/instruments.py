"""What a recording has beside IMUs: an encoder in the hinge, measured poses of segments, on the truth's own grid."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.dataset.ranges import Range, check_keys, chosen, number, parse_range
from imubench.models.tree import rig_tree
from imubench.recording import Encoder, Pose
from imubench.truth import Truth

SEGMENTS = ("segment1", "segment2")


@dataclass(frozen=True)
class EncoderRange:
    """The `[encoder]` of a spec: of rigs with a hinge."""

    probability: float
    noise_std: Range  # rad
    zero: Range  # rad

    def draw(self, rng: np.random.Generator, family: str) -> "DrawnEncoder | None":
        """Return a recording's encoder, if it has one."""
        there, drawn = rng.random() < self.probability, DrawnEncoder(self.noise_std.one(rng), self.zero.one(rng))
        return drawn if there and rig_tree(family).hinge is not None else None


@dataclass(frozen=True)
class DrawnEncoder:
    """An encoder as its owner declares it."""

    noise_std: float  # rad
    zero: float  # rad, added to the reading to give the joint angle

    def read(self, truth: Truth, effects: Sequence[Mapping[str, Any]], rng: np.random.Generator) -> Encoder:
        """Return what it reads; with `backlash` it sits on a side of the joint that follows with free play."""
        angle = truth.joint_angle
        assert angle is not None  # of a hinge
        for e in effects:
            if e["effect"] == "backlash":
                angle = followed(angle, e["parameters"]["range"])
        angle = angle - self.zero + self.noise_std * rng.standard_normal(angle.size)
        hinge = rig_tree(truth.rig).hinge
        assert hinge is not None  # `EncoderRange.draw` has looked
        return Encoder(hinge.name, truth.time, angle, self.noise_std, self.zero)


@dataclass(frozen=True)
class PoseRange:
    """One `[[pose]]` of a spec."""

    segment: str
    probability: float
    position_noise_std: Range  # m
    rotation_noise_std: Range  # rad

    def draw(self, rng: np.random.Generator, segments: Sequence[str]) -> "DrawnPose | None":
        """Return a recording's measured pose, if it has one."""
        there = rng.random() < self.probability and self.segment in segments
        drawn = DrawnPose(self.segment, self.position_noise_std.one(rng), self.rotation_noise_std.one(rng))
        return drawn if there else None


@dataclass(frozen=True)
class DrawnPose:
    """A measured pose as its owner declares it."""

    segment: str
    position_noise_std: float  # m, each axis
    rotation_noise_std: float  # rad, each axis

    def read(self, truth: Truth, rng: np.random.Generator) -> Pose:
        """Return what is measured."""
        moved = next(s for s in truth.segments if s.name == self.segment)
        noise = rng.standard_normal((2, truth.time.size, 3))
        position = moved.position + self.position_noise_std * noise[0]
        quaternion = rotations.multiply(moved.quaternion, rotations.exp(self.rotation_noise_std * noise[1]))
        return Pose(self.segment, truth.time, position, quaternion, self.position_noise_std, self.rotation_noise_std)


def parse_encoder(table: Any, where: str) -> EncoderRange | None:
    """Return the encoder of a spec; None where there is none."""
    if table is None:
        return None
    check_keys(table, ("probability", "noise_std", "zero"), where)
    return EncoderRange(
        number(table.get("probability", 1.0), f"{where}.probability", high=1.0),
        parse_range(table.get("noise_std", 5e-4), f"{where}.noise_std", 0.0),
        parse_range(table.get("zero", 0.0), f"{where}.zero"),
    )


def parse_pose(table: Mapping[str, Any], where: str) -> PoseRange:
    """Return one measured pose of a spec."""
    check_keys(table, ("segment", "probability", "position_noise_std", "rotation_noise_std"), where)
    return PoseRange(
        chosen(table.get("segment", "segment1"), f"{where}.segment", SEGMENTS),
        number(table.get("probability", 1.0), f"{where}.probability", high=1.0),
        parse_range(table.get("position_noise_std", 1e-3), f"{where}.position_noise_std", 0.0),
        parse_range(table.get("rotation_noise_std", 5e-3), f"{where}.rotation_noise_std", 0.0),
    )


def followed(angle: Array, play: float) -> Array:
    """Return the side (n,) of a joint that follows `angle` (n,) with free play of +-`play` rad, at first in its middle.

    Sample by sample x = clip(x, angle - play, angle + play). Clips in a row are a clip, so they are put together in
    pairs, fours, eights and so on.
    """
    low, high = angle - play, angle + play
    low[0] = high[0] = angle[0]
    reach = 1
    while reach < angle.size:
        before = low[:-reach].copy(), high[:-reach].copy()
        low[reach:], high[reach:] = (np.clip(edge, low[reach:], high[reach:]) for edge in before)
        reach *= 2
    return low
