"""Measurements as rows of a least-squares problem, and their normal equations."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.splines import SUPPORT, Tracks
from imubench.jets import CONSTANT, Jet

Whole = NDArray[np.int64]
Place = tuple[Whole, Whole]

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
        wide, r = self.local.shape[2] * self.local.shape[3], columns.shape[2]
        for begin, tall, _ in Stack([replace(self, border=columns)]).pieces():
            products = np.matmul(np.swapaxes(tall[:, :, :wide], 1, 2), tall[:, :, wide : wide + r])
            for s, some in enumerate(np.split(products, SUPPORT, axis=1)):
                target[begin + s : begin + s + len(tall)] += some


@dataclass(frozen=True)
class Order:
    """Samples by the knot they start at."""

    samples: Whole | None  # (n,) sorted by their knot, None where they are so already
    slot: Whole  # (n,) their places among those of their knot
    starts: Whole  # (knots + 1,) the first sample of every knot
    knot: Whole  # (n,) sorted

    @classmethod
    def of(cls, first: Whole) -> "Order":
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

    def among(self, begin: int, end: int) -> tuple[Whole | slice, Whole, Whole, int]:
        """Return the samples that start at knots begin..end, their knot from there, their place at it, the most."""
        low, high = (int(self.starts[min(k, self.knots)]) for k in (begin, end))
        slot = self.slot[low:high]
        some = slice(low, high) if self.samples is None else self.samples[low:high]
        return some, self.knot[low:high] - begin, slot, int(slot.max()) + 1 if len(slot) else 0


class Stack:
    """Rows of several kinds, by knots: those that start at some knots are one tall matrix for each of these."""

    def __init__(self, parts: Sequence[Linear]) -> None:
        self.parts = [(part, Order.of(part.first)) for part in parts]
        self.knots = max((order.knots for _, order in self.parts), default=0)

    def pieces(self) -> Iterator[tuple[int, Array, list[tuple[Whole | slice, Place]]]]:
        """Yield some knots' rows after another's: the first knot and (knots, rows, 6 width + p + 1), the residual last.

        With them for each kind which of its samples these are, and where their rows lie: knot and row, (k, m).
        """
        for begin in range(0, self.knots, CHUNK):
            yield begin, *self._piece(begin, min(begin + CHUNK, self.knots))

    def _piece(self, begin: int, end: int) -> tuple[Array, list[tuple[Whole | slice, Place]]]:
        chosen = [(part, *order.among(begin, end)) for part, order in self.parts]
        height = sum(count * part.residual.shape[1] for part, *_, count in chosen)
        local, border = self.parts[0][0].local, self.parts[0][0].border
        wide, p = local.shape[2] * local.shape[3], border.shape[2]
        tall = np.zeros((end - begin, height, wide + p + 1))
        at, places = 0, []
        for part, some, knot, slot, count in chosen:
            n, m = part.residual.shape
            place = (knot[:, None], at + slot[:, None] * m + np.arange(m))
            tall[(*place, slice(0, wide))] = part.local.reshape(n, m, wide)[some]
            tall[(*place, slice(wide, wide + p))] = part.border[some]
            tall[(*place, wide + p)] = part.residual[some]
            at += count * m
            places.append((some, place))
        return tall, places


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
