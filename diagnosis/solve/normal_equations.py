"""The normal equations of rows, by blocks of knots."""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.bspline import SUPPORT, Tracks
from imubench.diagnosis.problem.residuals import Parameters
from imubench.diagnosis.solve.block_tridiagonal import Banded
from imubench.diagnosis.solve.linearize import Linear, Stack
from imubench.diagnosis.solve.threads import side_by_side


@dataclass
class Normal:
    """The normal equations of all rows: band, border, corner and gradient."""

    diagonal: Array  # (m, b, b)
    right: Array  # (m, c, c), the last rows of a block by the first columns of the next
    border: Array  # (m, b, p)
    corner: Array  # (p, p)
    gradient: Array  # (m, b)
    corner_gradient: Array  # (p,)

    @classmethod
    def empty(cls, tracks: Tracks, parameters: Parameters) -> "Normal":
        """Return equations without a row."""
        b, c = ALGEBRA.knots_per_block * tracks.width, (SUPPORT - 1) * tracks.width
        m = -(-tracks.knots.count // ALGEBRA.knots_per_block) if b else 0
        p = parameters.count
        return cls(
            np.zeros((m, b, b)),
            np.zeros((m, c, c)),
            np.zeros((m, b, p)),
            np.zeros((p, p)),
            np.zeros((m, b)),
            np.zeros(p),
        )

    @classmethod
    def of(cls, tracks: Tracks, parameters: Parameters, parts: list[Linear]) -> "Normal":
        """Return the equations of some rows, ready to be solved."""
        normal = cls.empty(tracks, parameters)
        normal.add(parts)
        normal.fill(tracks)
        return normal

    def add(self, parts: list[Linear]) -> None:
        """Add the products of the rows, gathered by the knot they start at."""
        for part in (part for part in parts if any(part.border.strides)):
            shared = part.border.reshape(part.residual.size, part.border.shape[-1])  # a fold may have no row
            self.corner += shared.T @ shared
            self.corner_gradient += shared.T @ part.residual.reshape(-1)
        touching = [part for part in parts if part.blocks]
        if not self.diagonal.size or not touching:
            return
        wide = SUPPORT * parts[0].width
        stack = Stack(touching)

        def products(begin: int) -> Array:
            tall, _ = stack.piece(begin)
            return np.matmul(np.swapaxes(tall[:, :, :wide], 1, 2), tall)

        for begin, some in zip(stack.begins, side_by_side(products, stack.begins), strict=True):
            self._spread(begin // ALGEBRA.knots_per_block, some)  # a chunk is whole blocks

    def _spread(self, block: int, products: Array) -> None:
        """Add products (knots, 6 w, 6 w + p + 1) from a block on; what reaches beyond one is the next one's."""
        b = self.diagonal.shape[1]
        width = b // ALGEBRA.knots_per_block
        wide, top = SUPPORT * width, b - self.right.shape[1]
        for offset in range(ALGEBRA.knots_per_block):
            some = products[offset :: ALGEBRA.knots_per_block]
            here, after = slice(block, block + len(some)), slice(block + 1, block + 1 + len(some))
            at, inside = offset * width, min(wide, b - offset * width)
            over = wide - inside
            self.diagonal[here, at : at + inside, at : at + inside] += some[:, :inside, :inside]
            self.border[here, at : at + inside] += some[:, :inside, wide:-1]
            self.gradient[here, at : at + inside] += some[:, :inside, -1]
            if over:
                self.right[here, at - top :, :over] += some[:, :inside, inside:wide]
                self.diagonal[after, :over, :over] += some[:, inside:, inside:wide]
                self.border[after, :over] += some[:, inside:, wide:-1]
                self.gradient[after, :over] += some[:, inside:, -1]

    def fill(self, tracks: Tracks, ridge: float = ALGEBRA.ridge) -> None:
        """Hold the coefficients beyond the last knot, which no row touches, at zero change; all others by a share."""
        extra = len(self.diagonal) * ALGEBRA.knots_per_block - tracks.knots.count
        at = np.arange(self.diagonal.shape[1] - extra * tracks.width, self.diagonal.shape[1])
        if len(self.diagonal):
            self.damp(ridge)
            self.diagonal[-1, at, at] += 1.0

    def damp(self, share: float) -> None:
        """Add a share of the splines' diagonal to it."""
        every = np.arange(self.diagonal.shape[1])
        self.diagonal[:, every, every] *= 1 + share

    @property
    def band(self) -> Banded:
        """The matrix of the splines alone."""
        return Banded(self.diagonal, self.right)


__all__ = ["Normal"]
