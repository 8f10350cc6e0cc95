"""The normal equations of rows, by blocks of knots."""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.blocks import Banded
from imubench.diagnosis.rows import CHUNK, Linear, Parameters, Whole, slots
from imubench.diagnosis.splines import SUPPORT, Tracks

KNOTS_PER_BLOCK = 8  # more than SUPPORT, so that a row touches two blocks at most
RIDGE = 1e-12  # relative: what rounding may take from a diagonal beyond the first and last sample


@dataclass
class Normal:
    """The normal equations of all rows: band, border, corner and gradient."""

    diagonal: Array  # (m, b, b)
    right: Array  # (m, b, b)
    border: Array  # (m, b, p)
    corner: Array  # (p, p)
    gradient: Array  # (m, b)
    corner_gradient: Array  # (p,)

    @classmethod
    def empty(cls, tracks: Tracks, parameters: Parameters) -> "Normal":
        """Return equations without a row."""
        b = KNOTS_PER_BLOCK * tracks.width
        m = -(-tracks.knots.count // KNOTS_PER_BLOCK) if b else 0
        p = parameters.count
        return cls(
            np.zeros((m, b, b)),
            np.zeros((m, b, b)),
            np.zeros((m, b, p)),
            np.zeros((p, p)),
            np.zeros((m, b)),
            np.zeros(p),
        )

    def add(self, parts: list[Linear]) -> None:
        """Add the products of the rows, gathered by the knot they start at."""
        for part in parts:
            wide = part.border.reshape(part.residual.size, -1)
            self.corner += wide.T @ wide
            self.corner_gradient += wide.T @ part.residual.reshape(-1)
        if not self.diagonal.size:
            return
        last = max(int(part.first.max()) for part in parts if len(part.first))
        for begin in range(0, last + 1, CHUNK):
            self._add(begin, min(begin + CHUNK, last + 1), parts)

    def _add(self, begin: int, end: int, parts: list[Linear]) -> None:
        """Add what starts at knots begin..end: one tall matrix a knot, one product of each."""
        chosen = [slots(part.first, begin, end) for part in parts]
        height = sum(count * part.residual.shape[1] for (_, _, _, count), part in zip(chosen, parts, strict=True))
        p, wide = self.border.shape[2], parts[0].local.shape[2] * parts[0].local.shape[3]
        tall = np.zeros((end - begin, height, wide + p + 1))
        at = 0
        for (some, knot, slot, count), part in zip(chosen, parts, strict=True):
            if count:
                m = part.residual.shape[1]
                place = (knot[:, None], at + slot[:, None] * m + np.arange(m))
                tall[(*place, slice(0, wide))] = part.local[some].reshape(len(some), m, wide)
                tall[(*place, slice(wide, wide + p))] = part.border[some]
                tall[(*place, wide + p)] = part.residual[some]
                at += count * m
        products = np.matmul(np.swapaxes(tall[:, :, :wide], 1, 2), tall)
        knots: Whole = np.arange(begin, end, dtype=np.int64)
        self._spread(knots, products[:, :, :wide])
        self._spread_columns(self.border, knots, products[:, :, wide : wide + p])
        self._spread_columns(self.gradient[:, :, None], knots, products[:, :, wide + p :])

    def _spread(self, knots: Whole, products: Array) -> None:
        b = self.diagonal.shape[1]
        width = b // KNOTS_PER_BLOCK
        for offset in range(KNOTS_PER_BLOCK):
            here = knots % KNOTS_PER_BLOCK == offset
            block, some = knots[here] // KNOTS_PER_BLOCK, products[here]
            at, inside = offset * width, min(SUPPORT * width, b - offset * width)
            self.diagonal[block, at : at + inside, at : at + inside] += some[:, :inside, :inside]
            if inside < SUPPORT * width:
                over = SUPPORT * width - inside
                self.right[block, at:, :over] += some[:, :inside, inside:]
                self.diagonal[block + 1, :over, :over] += some[:, inside:, inside:]

    def _spread_columns(self, target: Array, knots: Whole, columns: Array) -> None:
        b = self.diagonal.shape[1]
        width = b // KNOTS_PER_BLOCK
        for offset in range(KNOTS_PER_BLOCK):
            here = knots % KNOTS_PER_BLOCK == offset
            block, some = knots[here] // KNOTS_PER_BLOCK, columns[here]
            at, inside = offset * width, min(SUPPORT * width, b - offset * width)
            target[block, at : at + inside] += some[:, :inside]
            if inside < SUPPORT * width:
                target[block + 1, : SUPPORT * width - inside] += some[:, inside:]

    def fill(self, tracks: Tracks, ridge: float = RIDGE) -> None:
        """Hold the coefficients beyond the last knot, which no row touches, at zero change; all others by a share."""
        extra = len(self.diagonal) * KNOTS_PER_BLOCK - tracks.knots.count
        at = np.arange(self.diagonal.shape[1] - extra * tracks.width, self.diagonal.shape[1])
        every = np.arange(self.diagonal.shape[1])
        if len(self.diagonal):
            self.diagonal[:, every, every] *= 1 + ridge
            self.diagonal[-1, at, at] += 1.0

    @property
    def band(self) -> Banded:
        """The matrix of the splines alone."""
        return Banded(self.diagonal, self.right)


__all__ = ["Normal"]
