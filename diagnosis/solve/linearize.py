"""Rows by the knots that they touch, whitened, with their Jacobian: what normal equations are made of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.alike_rows import alike, run
from imubench.diagnosis.problem.bspline import SUPPORT, Knots, Tracks
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.solve.threads import side_by_side
from imubench.jets import CONSTANT

Whole = NDArray[np.int64]
Place = tuple[Whole, Whole]
Some = Whole | NDArray[np.bool_] | slice


@dataclass(frozen=True)
class Linear:
    """Rows by the knots they touch: first one (n,), border (n, m, p), residual (n, m).

    Their Jacobian by the splines is made for some samples at a time. All of it, a hundred numbers for each of thirty
    rows at every knot, would be most of what the fit of a long recording holds.
    """

    first: Whole
    border: Array
    residual: Array
    scale: Array  # (n, m), one over the standard deviations
    blocks: tuple[tuple[slice, int, Array], ...]  # of the splines: columns of a knot, order, derivative (n or 1, m, k)
    weights: dict[int, Array]  # (n, 6) of every order
    width: int  # numbers per knot
    knots: Knots
    phase: float | None = None  # where in their intervals, of length 1, all samples lie alike; None: they do not

    def of(self, some: Some) -> Linear:
        """Return some of the samples' rows."""
        n = len(self.first)
        blocks = tuple((at, order, d[some] if len(d) == n else d) for at, order, d in self.blocks)
        weights = {order: w[some] for order, w in self.weights.items()}
        border, residual, scale = (x[some] for x in (self.border, self.residual, self.scale))
        return replace(
            self,
            first=self.first[some],
            border=border,
            residual=residual,
            scale=scale,
            blocks=blocks,
            weights=weights,
        )

    @cached_property
    def touched(self) -> slice:
        """The numbers of a knot from the first to the last on which the rows depend."""
        columns = [at for at, _, _ in self.blocks]
        return slice(min((at.start for at in columns), default=0), max((at.stop for at in columns), default=0))

    def local(self, some: Some, own: slice) -> Array:
        """Return the Jacobian (k, m, 6, w) of some samples by some numbers of the knots that they touch."""
        n, m = self.residual.shape
        scale = self.scale[some].T
        out = np.zeros((m, SUPPORT, own.stop - own.start, scale.shape[1]))  # samples next to each other, as in jets
        for columns, order, block in self.blocks:
            slope = (block[some] if len(block) == n else block).transpose(1, 2, 0) * scale[:, None]
            at = slice(columns.start - own.start, columns.stop - own.start)
            out[:, :, at] += slope[:, None] * self.weights[order][some].T[None, :, None]
        return out.transpose(3, 0, 1, 2)

    def along(self, knots: Array) -> Array:
        """Return J times columns of the splines (knots, width, r), as (n, m, r)."""
        out = np.zeros((*self.residual.shape, knots.shape[2]))
        if not self.blocks:
            return out
        reach = np.arange(SUPPORT)
        for begin in range(0, len(out), ALGEBRA.piece_samples):
            some = slice(begin, begin + ALGEBRA.piece_samples)
            near = knots[self.first[some, None] + reach]
            for columns, order, block in self.blocks:
                slope = (block[some] if len(block) == len(out) else block) * self.scale[some][:, :, None]
                value = np.einsum("ns,nskr->nkr", self.weights[order][some], near[:, :, columns])
                out[some] += np.matmul(slope, value)
        return out

    def by_knot(self, columns: Array) -> Iterator[tuple[int, Array]]:
        """Yield J' of further columns (n, m, r) of the samples that start at a knot, (knots, 6, width, r), by pieces.

        J is the splines' Jacobian; the first knot of a piece comes before it.
        """
        wide, r = SUPPORT * self.width, columns.shape[2]
        stack = Stack([replace(self, border=columns)])

        def products(begin: int) -> Array:
            tall, _ = stack.piece(begin)
            both = np.matmul(np.swapaxes(tall[:, :, :wide], 1, 2), tall[:, :, wide : wide + r])
            return both.reshape(len(tall), SUPPORT, self.width, r)

        yield from zip(stack.begins, side_by_side(products, stack.begins), strict=True)

    def scatter(self, columns: Array, target: Array) -> None:
        """Add J' of further columns (n, m, r) to `target` (knots, width, r), J the splines' Jacobian."""
        for begin, products in self.by_knot(columns):
            _gather(begin, products, target)


def _gather(begin: int, products: Array, target: Array) -> None:
    """Add J' of columns (knots, 6, width, r) of samples that start at some knots from one on to `target`."""
    for s in range(SUPPORT):
        target[begin + s : begin + s + len(products)] += products[:, s]


@dataclass(frozen=True)
class Held:
    """Rows' Jacobian by the splines, made once for many columns that are multiplied with it."""

    pieces: tuple[tuple[int, Array, Whole | slice, Place], ...]  # first knot, J (knots, rows, 6 width), samples, places
    width: int  # numbers per knot

    @classmethod
    def of(cls, part: Linear) -> Held:
        """Return the Jacobian of some rows, a hundred numbers for each."""
        stack, wide = Stack([part]), SUPPORT * part.width
        pieces = []
        for begin in stack.begins:
            tall, [(some, place)] = stack.piece(begin)
            pieces.append((begin, np.ascontiguousarray(tall[:, :, :wide]), some, place))
        return cls(tuple(pieces), part.width)

    def scatter(self, columns: Array, target: Array) -> None:
        """Add J' of further columns (n, m, r) to `target` (knots, width, r)."""
        r = columns.shape[2]
        for begin, tall, some, place in self.pieces:
            own = np.zeros((*tall.shape[:2], r))
            own[place] = columns[some]
            both = np.matmul(np.swapaxes(tall, 1, 2), own)
            _gather(begin, both.reshape(len(tall), SUPPORT, self.width, r), target)


def linearise(rows: Rows, tracks: Tracks, parameters: Parameters) -> Linear:
    """Return whitened Jacobian and residual of `rows`."""
    n, m = rows.residual.value.shape
    n = max(n, len(rows.time))
    scale = 1 / np.broadcast_to(rows.std, (n, m))
    known = {name: block for (name, order), block in rows.residual.blocks.items() if order == CONSTANT}
    known = {name: block for name, block in known.items() if name in parameters.widths}
    border = np.broadcast_to(0.0, (n, m, parameters.count))
    if known:
        border = np.zeros(border.shape)
        for name, block in known.items():
            border[:, :, parameters.columns(name)] += block
        border *= scale[:, :, None]
    blocks = tuple(
        (tracks.columns(name), order, block)
        for (name, order), block in rows.residual.blocks.items()
        if order != CONSTANT and name in tracks.widths
    )
    first, phase = np.zeros(n, dtype=np.int64), None
    if tracks.width:
        first, phase = tracks.knots.weights(rows.time, 0)[0], tracks.knots.phase(rows.time)
    weights = {order: tracks.knots.weights(rows.time, order)[1] for order in {order for _, order, _ in blocks}}
    residual = np.broadcast_to(rows.residual.value, (n, m)) * scale
    return Linear(first, border, residual, scale, blocks, weights, tracks.width, tracks.knots, phase)


@dataclass(frozen=True)
class Order:
    """Samples by the knot they start at."""

    samples: Whole | None  # (n,) sorted by their knot, None where they are so already
    slot: Whole  # (n,) their places among those of their knot
    starts: Whole  # (knots + 1,) the first sample of every knot
    knot: Whole  # (n,) sorted

    @classmethod
    def of(cls, first: Whole) -> Order:
        """Return the order of samples that start at knots (n,)."""
        sorted_already = bool(np.all(first[1:] >= first[:-1]))
        samples = None if sorted_already else np.argsort(first, kind="stable").astype(np.int64)
        knot = first if samples is None else first[samples]
        starts: Whole = np.searchsorted(knot, np.arange(int(knot[-1]) + 2 if len(knot) else 1)).astype(np.int64)
        return cls(samples, np.arange(len(knot), dtype=np.int64) - starts[knot], starts, knot)

    @property
    def knots(self) -> int:
        """How many knots there are up to the last that a sample starts at."""
        return len(self.starts) - 1

    def among(self, begin: int, end: int) -> tuple[Whole | slice, Whole, Whole]:
        """Return the samples that start at knots begin..end, their knot from there, their place at it."""
        low, high = (int(self.starts[min(k, self.knots)]) for k in (begin, end))
        some = slice(low, high) if self.samples is None else self.samples[low:high]
        return some, self.knot[low:high] - begin, self.slot[low:high]


def chunk_knots(width: int) -> int:
    """Return at how many knots, of so many numbers each, rows are put together at once: whole blocks of them."""
    blocks = ALGEBRA.chunk_numbers // ((SUPPORT * max(width, 1)) ** 2 * ALGEBRA.knots_per_block)
    return max(blocks, 1) * ALGEBRA.knots_per_block


class Stack:
    """Rows of several kinds, by knots: those that start at some knots are one tall matrix for each of these.

    At every knot each kind has its rows, and behind all of these come those of a second sample of a kind, and a third.
    """

    def __init__(self, parts: Sequence[Linear]) -> None:
        self.chunk = chunk = chunk_knots(parts[0].width)
        self.parts = [(part, Order.of(part.first)) for part in parts]
        self.alike = alike(parts)
        self.quick = {i for group in self.alike for i in group.members}
        self.starts = [0] * len(parts)  # of each kind's rows
        self.rows = 0
        for i in [*(i for group in self.alike for i in group.members), *set(range(len(parts))) - self.quick]:
            self.starts[i] = self.rows
            self.rows += parts[i].residual.shape[1]
        self.knots = max((order.knots for _, order in self.parts), default=0)
        first = min((int(order.knot[0]) for _, order in self.parts if len(order.knot)), default=0)
        self.begins = range(first - first % chunk, self.knots, chunk)  # the first knots of the pieces

    def piece(self, begin: int) -> tuple[Array, list[tuple[Whole | slice, Place]]]:
        """Return the rows at some knots from one of `begins` on, (knots, rows, 6 width + p + 1), the residual last.

        With them for each kind which of its samples these are, and where their rows lie: knot and row, (k, m).
        """
        end = min(begin + self.chunk, self.knots)
        chosen = [order.among(begin, end) for _, order in self.parts]
        filled = np.full(end - begin, self.rows, dtype=np.int64)  # rows at every knot so far
        places: list[tuple[Whole | slice, Place]] = []
        for (part, _), (some, knot, slot), start in zip(self.parts, chosen, self.starts, strict=True):
            m, more = part.residual.shape[1], slot > 0
            row = np.full(len(knot), start)
            if more.any():
                row[more] = filled[knot[more]] + (slot[more] - 1) * m
                filled += m * np.bincount(knot[more], minlength=len(filled))
            places.append((some, (knot[:, None], row[:, None] + np.arange(m))))
        width, p = self.parts[0][0].width, self.parts[0][0].border.shape[2]
        wide = SUPPORT * width
        tall = np.zeros((end - begin, int(filled.max(initial=0)), wide + p + 1))
        by_knot = tall[:, :, :wide].reshape(*tall.shape[:2], SUPPORT, width)
        for group in self.alike:
            group.fill(tall[:, :, :wide], [part for part, _ in self.parts], [(some, knot) for some, knot, _ in chosen])
        for i, (some, (knot, row)) in enumerate(places):
            part, m = self.parts[i][0], self.parts[i][0].residual.shape[1]
            single = int(row[:, 0].max(initial=0)) < self.rows
            at = (run(knot[:, 0]), slice(self.starts[i], self.starts[i] + m)) if single else (knot, row)
            if i not in self.quick and part.blocks:
                own = part.touched
                by_knot[(*at, slice(None), own)] = part.local(some, own)
            if any(part.border.strides):
                tall[(*at, slice(wide, wide + p))] = part.border[some]
            tall[(*at, wide + p)] = part.residual[some]
        return tall, places
