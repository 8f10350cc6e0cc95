"""Measurements as rows of a least-squares problem, and their normal equations."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.splines import SUPPORT, Tracks
from imubench.jets import CONSTANT, Jet

Whole = NDArray[np.int64]

CHUNK = 256  # knots whose products are formed at once: what stays in the cache


@dataclass(frozen=True)
class Rows:
    """Residuals of one kind, model minus measurement, whitened: `std` is one standard deviation."""

    name: str  # as "imu1.gyro"
    time: Array  # (n,) s, where on the splines
    residual: Jet  # (n, m), in the unit of `std`
    std: Array  # (m,) or (n, m)
    counts: bool = True  # False: a prior, not a measurement

    @property
    def whitened(self) -> Array:
        """Residuals (n, m) over their standard deviation."""
        return self.residual.value / self.std

    @property
    def cost(self) -> float:
        """Half the sum of the squares."""
        return 0.5 * float(np.sum(self.whitened**2))


@dataclass(frozen=True)
class Parameters:
    """The numbers that the whole recording shares, by name: where each lies in one vector."""

    widths: dict[str, int]

    @property
    def count(self) -> int:
        """How many numbers there are."""
        return sum(self.widths.values())

    def places(self, names: Sequence[str]) -> NDArray[np.intp]:
        """Return where the numbers of some parameters lie in the vector, in this order."""
        return np.concatenate([np.r_[self.columns(name)] for name in names])

    def columns(self, name: str) -> slice:
        """Return where a parameter lies in the vector."""
        at = 0
        for known, width in self.widths.items():
            if known == name:
                return slice(at, at + width)
            at += width
        raise KeyError(name)


@dataclass(frozen=True)
class Linear:
    """Rows by the knots they touch: first one (n,), blocks (n, m, 6, width), border (n, m, p), residual (n, m)."""

    first: Whole
    local: Array
    border: Array
    residual: Array

    def along(self, knots: Array) -> Array:
        """Return J times columns of the splines (knots, width, r), as (n, m, r)."""
        out = np.zeros((*self.residual.shape, knots.shape[2]))
        for i in range(SUPPORT):  # a sixth of the splines at a time: less memory than all windows at once
            out += np.matmul(self.local[:, :, i], knots[self.first + i])
        return out

    def scatter(self, columns: Array, target: Array) -> None:
        """Add J' of further columns (n, m, r) to `target` (knots, width, r), J the splines' Jacobian."""
        m, r = columns.shape[1:]
        wide = self.local.shape[2] * self.local.shape[3]
        last = int(self.first.max()) if len(self.first) else -1
        for begin in range(0, last + 1, CHUNK):
            end = min(begin + CHUNK, last + 1)
            some, knot, slot, count = slots(self.first, begin, end)
            tall, beside = np.zeros((end - begin, count, m, wide)), np.zeros((end - begin, count, m, r))
            tall[knot, slot] = self.local[some].reshape(len(some), m, wide)
            beside[knot, slot] = columns[some]
            left, right = tall.reshape(end - begin, count * m, wide), beside.reshape(end - begin, count * m, r)
            products = np.matmul(np.swapaxes(left, 1, 2), right).reshape(end - begin, SUPPORT, -1, r)
            for s in range(SUPPORT):
                target[begin + s : end + s] += products[:, s]


def slots(first: Whole, begin: int, end: int) -> tuple[Whole, Whole, Whole, int]:
    """Return the samples that start at these knots, their knot, their place among those of the knot, the most."""
    inside = np.flatnonzero((first >= begin) & (first < end))
    some: Whole = inside[np.argsort(first[inside], kind="stable")].astype(np.int64)
    knot = first[some] - begin
    if not len(some):
        return some, knot, knot, 0
    edges = np.flatnonzero(np.diff(knot, prepend=-1))
    counts = np.diff(np.append(edges, len(knot)))
    slot: Whole = np.arange(len(knot), dtype=np.int64) - np.repeat(edges, counts)
    return some, knot, slot, int(counts.max())


def linearise(rows: Rows, tracks: Tracks, parameters: Parameters) -> Linear:
    """Return whitened Jacobian and residual of `rows`."""
    n, m = rows.residual.value.shape
    n = max(n, len(rows.time))
    local = np.zeros((n, m, SUPPORT, tracks.width))
    border = np.zeros((n, m, parameters.count))
    first: Whole = np.zeros(n, dtype=np.int64)
    if tracks.width:
        first, _ = tracks.knots.weights(rows.time, 0)
    weights = {
        order: tracks.knots.weights(rows.time, order)[1]
        for order in {order for name, order in rows.residual.blocks if name in tracks.widths and order != CONSTANT}
    }
    for (name, order), block in rows.residual.blocks.items():
        if order == CONSTANT:
            if name in parameters.widths:
                border[:, :, parameters.columns(name)] += block
        elif name in tracks.widths:
            wide = np.ascontiguousarray(block)[:, :, None, :]
            local[:, :, :, tracks.columns(name)] += wide * weights[order][:, None, :, None]
    scale = 1 / np.broadcast_to(rows.std, (n, m))
    local *= scale[:, :, None, None]
    border *= scale[:, :, None]
    return Linear(first, local, border, np.broadcast_to(rows.residual.value, (n, m)) * scale)
