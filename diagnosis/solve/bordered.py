"""Block-tridiagonal matrices with a dense border, solved, and ready for more right-hand sides.

The few numbers that the whole recording shares (geometry, effects) are the border of the splines' matrix::

    [ N   B ] [ x ]   [ g ]
    [ B'  C ] [ p ] = [ h ]
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.solve.block_tridiagonal import Banded, Factor, NotPositiveDefiniteError


@dataclass(frozen=True)
class Solution:
    """A solved arrow system, ready for more right-hand sides."""

    factor: Factor
    border: Array  # (m, b, p): B
    half: Array  # (m, b, p): L^-1 B
    schur: Array  # (p, p): C - B' N^-1 B, whose inverse is the parameters' covariance

    @property
    def log_det(self) -> float:
        """The log determinant of the whole arrow matrix."""
        return self.factor.log_det + float(np.linalg.slogdet(self.schur)[1])

    def reduced(self, g: Array, h: Array, fresh: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return information (k, k) and gradient (k,) of the shared numbers `fresh` once all the rest has followed.

        g (m, b) and h (p,) are the gradient of the splines and of the shared numbers.
        """
        gradient = h - np.einsum("mbp,mb->p", self.half, self.factor.forward(g[:, :, None])[:, :, 0])
        old = np.setdiff1d(np.arange(len(h)), fresh)
        known = np.linalg.solve(self.schur[np.ix_(old, old)], self.schur[np.ix_(old, fresh)])
        information = self.schur[np.ix_(fresh, fresh)] - self.schur[np.ix_(fresh, old)] @ known
        return np.asarray(information), np.asarray(gradient[fresh] - known.T @ gradient[old])

    def solve(self, g: Array, h: Array) -> tuple[Array, Array]:
        """Return x (m, b, r) and p (q, r) for right-hand sides g (m, b, r), h (q, r)."""
        front = self.factor.forward(g)
        try:
            p = np.linalg.solve(self.schur, h - tensor(self.half, front)) if len(h) else h
        except np.linalg.LinAlgError:
            raise NotPositiveDefiniteError("the shared parameters") from None
        return self.factor.backward(front - self.half @ p), np.asarray(p, dtype=float)

    def complement(self, g: Array, h: Array, c: Array) -> Array:
        """Return the Schur complement (r, r) of further columns: their products with the system and themselves."""
        return self.complements(g[..., None], h[..., None], c)

    def complements(self, g: Array, h: Array, c: Array) -> Array:
        """Return the sum (r, r) of d Schur complements, for g (m, b, r, d), h (p, r, d) and the sum c (r, r) of theirs.

        Some draws' columns are solved at once, for what a solve costs beside its arithmetic, and not all, which would
        be held four times over.
        """
        (m, b, r, d), p = g.shape, len(h)
        out = np.array(c)
        at_once = max(ALGEBRA.columns // max(r, 1), 1)
        for some in (slice(i, i + at_once) for i in range(0, d, at_once)):
            columns = np.ascontiguousarray(g[..., some])
            n = columns.shape[3]
            front = self.factor.forward(columns.reshape(m, b, r * n)).reshape(m * b, r * n)
            rest = h[..., some].reshape(p, r * n) - tensor(self.half, front.reshape(m, b, r * n))
            out = out - _inner(front.reshape(m * b, r, n), front.reshape(m * b, r, n))
            if p:
                solved = np.asarray(np.linalg.solve(self.schur, rest), dtype=float)
                out = out - _inner(rest.reshape(p, r, n), solved.reshape(p, r, n))
        return (out + out.T) / 2


def solve_arrow(band: Banded, border: Array, corner: Array) -> Solution:
    """Factor the arrow matrix of `band`, whose memory it takes, border (m, b, p) and corner (p, p)."""
    factor = band.factor()
    half = factor.forward(border) if border.shape[2] else border
    return Solution(factor, border, half, corner - tensor(half, half))


def tensor(a: Array, b: Array) -> Array:
    """Return A' B of block columns (m, b, p) and (m, b, r)."""
    rows = a.shape[0] * a.shape[1]
    return a.reshape(rows, a.shape[2]).T @ b.reshape(rows, b.shape[2])


def _inner(a: Array, b: Array) -> Array:
    """Return the sum (r, q) over rows and draws of the products of a (n, r, d) and b (n, q, d)."""
    if a.shape[2] == 1:  # without the copies that the general product makes
        return np.asarray(a[:, :, 0].T @ b[:, :, 0])
    return np.asarray(np.tensordot(a, b, axes=((0, 2), (0, 2))))
