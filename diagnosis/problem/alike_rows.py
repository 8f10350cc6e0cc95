"""Rows whose samples all lie at the same place between knots: their Jacobians by products with one matrix.

By the splines a row's Jacobian is D W: D (k,) its derivatives by the values of splines and of their time derivatives, W
(k, 6 width) how these depend on six knots. Samples of a clock that ticks with the knots, laws and priors in the middle
of the intervals share W, and their rows at all knots are one product of matrices.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.problem.bspline import SUPPORT, Knots

Whole = NDArray[np.int64]
Blocks = tuple[tuple[slice, int, Array], ...]


class Placed(Protocol):
    """Whitened rows, as far as their places go."""

    @property
    def first(self) -> Whole:
        """The first knot (n,) that each sample touches."""

    @property
    def scale(self) -> Array:
        """One over the standard deviations (n, m)."""

    @property
    def blocks(self) -> Blocks:
        """Columns of a knot, order, and the derivative (n or 1, m, k) by these."""

    @property
    def width(self) -> int:
        """Numbers per knot."""

    @property
    def knots(self) -> Knots:
        """All knots."""

    @property
    def phase(self) -> float | None:
        """Where in their intervals, of length 1, all samples lie alike; None: they do not."""


@dataclass(frozen=True)
class Alike:
    """Kinds of rows that share a place between knots, at most one sample of each kind at a knot."""

    members: tuple[int, ...]  # which of some kinds these are
    starts: tuple[int, ...]  # the first row of each at a knot
    rows: int  # at a knot
    columns: dict[tuple[int, int], slice]  # where the derivatives by a spline's numbers lie, by first column and order
    weights: Array  # (k, 6 width): W

    @classmethod
    def of(cls, parts: Sequence[Placed], members: Sequence[int], row: int) -> "Alike":
        """Return some of the kinds together, their rows from one on."""
        starts, columns, at = [], {}, 0
        for i in members:
            starts.append(row)
            row += parts[i].scale.shape[1]
            for where, order, _ in parts[i].blocks:
                if (where.start, order) not in columns:
                    columns[where.start, order] = slice(at, at + where.stop - where.start)
                    at += where.stop - where.start
        one = parts[members[0]]
        assert one.phase is not None
        weights = np.zeros((at, SUPPORT, one.width))
        for (first, order), own in columns.items():
            count = own.stop - own.start
            weights[np.arange(own.start, own.stop), :, np.arange(first, first + count)] = one.knots.weights_at(
                one.phase, order
            )
        return cls(tuple(members), tuple(starts), row - starts[0], columns, weights.reshape(at, SUPPORT * one.width))

    def fill(self, tall: Array, parts: Sequence[Placed], chosen: Sequence[tuple[Whole | slice, Whole]]) -> None:
        """Write Jacobians into `tall` (knots, rows, 6 width), of the samples `chosen` of each kind at some knots."""
        slopes = np.zeros((len(tall), self.rows, len(self.weights)))
        for i, start in zip(self.members, self.starts, strict=True):
            part, (some, knot) = parts[i], chosen[i]
            scale = part.scale[some][:, :, None]
            own = slice(start - self.starts[0], start - self.starts[0] + part.scale.shape[1])
            for where, order, block in part.blocks:
                d = block[some] if len(block) == len(part.first) else block
                slopes[run(knot), own, self.columns[where.start, order]] = d * scale
        np.matmul(slopes, self.weights, out=tall[:, self.starts[0] : self.starts[0] + self.rows])


def alike(parts: Sequence[Placed]) -> list[Alike]:
    """Return the kinds of rows that share a place, by place, rows one after the other; the others are in none."""
    places: list[tuple[float, list[int]]] = []
    for i, part in enumerate(parts):
        if part.phase is None or not part.blocks or np.any(np.diff(part.first) <= 0):
            continue
        members = next((m for phase, m in places if abs(phase - part.phase) < part.knots.rounding), None)
        if members is None:
            places.append((part.phase, [i]))
        else:
            members.append(i)
    out, row = [], 0
    for _, members in places:
        out.append(Alike.of(parts, members, row))
        row += out[-1].rows
    return out


def run(knot: Whole) -> slice | Whole:
    """Return increasing knots as a slice where none is left out between them."""
    if len(knot) and int(knot[-1]) - int(knot[0]) == len(knot) - 1:
        return slice(int(knot[0]), int(knot[-1]) + 1)
    return knot


__all__ = ["Alike", "alike"]
