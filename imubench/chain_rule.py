"""A body's motion as variables of its own: laws beyond it carry nine derivatives instead of those of every spline.

What an IMU reads depends on the splines only through the angular rate, the angular acceleration, the specific force and
the attitude of the segment that carries it. Derivatives by these are taken on to the splines once, at the end::

    d reading / d spline = sum over x of (d reading / d x) (d x / d spline)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.jets import CONSTANT, Blocks, Jet, Key, Turn, times
from imubench.links import Motion

RATE, ACCEL, FORCE, TURN = (("segment." + part, CONSTANT) for part in ("rate", "accel", "force", "turn"))


@dataclass(frozen=True)
class Inner:
    """The derivatives of a vector by all blocks that it depends on, side by side."""

    slope: Array  # (n or 1, 3, k)
    places: Mapping[Key, slice]  # of the blocks among the k

    @classmethod
    def of(cls, blocks: Blocks) -> Inner:
        """Return the derivatives (n or 1, 3, k) of some blocks; samples lie next to each other as in `jets`."""
        places, at = {}, 0
        for key, d in blocks.items():
            places[key] = slice(at, at + d.shape[2])
            at += d.shape[2]
        slope = np.empty((3, at, max(len(d) for d in blocks.values())))
        for key, d in blocks.items():
            slope[:, places[key]] = d.transpose(1, 2, 0)
        return cls(slope.transpose(2, 0, 1), places)


@dataclass(frozen=True)
class Carrier(Motion):
    """A body's motion in variables of its own, and what these depend on."""

    inner: Mapping[Key, Inner] | None = None


def carrier(motion: Motion) -> Carrier:
    """Return a motion whose vectors are variables, where they depend on more numbers than they have themselves."""
    inner: dict[Key, Inner] = {}

    def own(key: Key, blocks: Blocks) -> Blocks:
        if sum(d.shape[2] for d in blocks.values()) <= 3:
            return blocks
        inner[key] = Inner.of(blocks)
        return {key: np.eye(3)[None]}

    vectors = {RATE: motion.rate, ACCEL: motion.accel, FORCE: motion.force}
    rate, accel, force = (Jet(v.value, own(key, v.blocks)) for key, v in vectors.items())
    turn = None if motion.turn is None else Turn(motion.turn.matrix, own(TURN, motion.turn.blocks))
    return Carrier(rate, accel, force, turn, motion.position, inner)


def chained(jet: Jet, motion: Motion) -> Jet:
    """Return a jet whose derivatives by the variables of a `Carrier` are taken on to what these depend on."""
    inner = motion.inner if isinstance(motion, Carrier) else None
    if not inner or not any(key in inner for key in jet.blocks):
        return jet
    blocks = {key: d for key, d in jet.blocks.items() if key not in inner}
    for key, outer in jet.blocks.items():
        if key not in inner:
            continue
        through = inner[key]
        whole = times(outer, through.slope)
        for name, columns in through.places.items():
            d = whole[:, :, columns]
            blocks[name] = blocks[name] + d if name in blocks else d
    return replace(jet, blocks=blocks)


__all__ = ["Carrier", "carrier", "chained"]
