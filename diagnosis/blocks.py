"""Block-tridiagonal matrices with a dense border: how a long fit stays linear in its length.

Knots are gathered into blocks; a measurement touches at most two neighbouring ones. The few
numbers that the whole recording shares (geometry, effects) are the border::

    [ N   B ] [ x ]   [ g ]
    [ B'  C ] [ p ] = [ h ]
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dtrtri, dtrtrs

from imubench.arrays import Array

RIDGES = (0.0, 1e-13, 1e-12)  # of a block's diagonal: what rounding may take from it, where it did


class NotPositiveDefiniteError(ArithmeticError):
    """A direction that neither a measurement nor a prior holds."""


@dataclass(frozen=True)
class Banded:
    """A symmetric block-tridiagonal matrix: its diagonal (m, b, b), and right of it (m, c, c), the last unused.

    A block's right neighbour is zero but for its last c rows and first c columns: a band's far corner.
    """

    diagonal: Array
    right: Array

    @property
    def top(self) -> int:
        """The first row of a block that its right neighbour has."""
        return self.diagonal.shape[1] - self.right.shape[1]

    def factor(self) -> "Factor":
        """Return its Cholesky factor, which takes the matrix' memory; `NotPositiveDefiniteError` names the block.

        The matrix is gone: that of a long fit has half a gigabyte.
        """
        count, over, top = len(self.diagonal), self.right.shape[1], self.top
        lower, coupling = self.diagonal.transpose(0, 2, 1), self.right.transpose(0, 2, 1)  # by columns, for LAPACK
        rest = self.diagonal[0]
        for i in range(count):
            chol = _cholesky(rest)
            if chol is None:
                raise NotPositiveDefiniteError(f"block {i} of {count}")
            lower[i] = chol
            if i + 1 < count and over:
                z, _ = dtrtrs(chol[top:, top:], self.right[i], lower=1)
                coupling[i] = z
                rest = self.diagonal[i + 1].copy()
                rest[:over, :over] -= z.T @ z
        return Factor(lower, coupling)


def _cholesky(matrix: Array) -> Array | None:
    """Return a matrix' lower factor, where it has none the one of a matrix that rounding cannot tell from it."""
    for ridge in RIDGES:
        chol, info = dpotrf(matrix + ridge * np.diag(np.diagonal(matrix)) if ridge else matrix, lower=1, clean=1)
        if not info:
            return np.asarray(chol)
    return None


@dataclass(frozen=True)
class Factor:
    """N = L L' with L block-bidiagonal: `lower` (m, b, b) and what is not zero of L_i^-1 N_i,i+1 (m, c, c)."""

    lower: Array
    coupling: Array

    @property
    def over(self) -> int:
        """How many of its last rows a block's right neighbour has, and how many first columns."""
        return self.coupling.shape[1]

    @property
    def top(self) -> int:
        """The first row that a block's right neighbour has."""
        return self.lower.shape[1] - self.over

    @property
    def log_det(self) -> float:
        """The log determinant of N."""
        return 2 * float(np.log(np.diagonal(self.lower, axis1=1, axis2=2)).sum())

    def forward(self, rhs: Array) -> Array:
        """Return L^-1 rhs for rhs (m, b, r)."""
        out = np.empty_like(rhs)
        carry = rhs[0]
        for i in range(len(rhs)):
            out[i], _ = dtrtrs(self.lower[i], carry, lower=1)
            if i + 1 < len(rhs):
                carry = rhs[i + 1].copy()
                carry[: self.over] -= self.coupling[i].T @ out[i, self.top :]
        return out

    def backward(self, rhs: Array) -> Array:
        """Return L'^-1 rhs for rhs (m, b, r)."""
        out = np.empty_like(rhs)
        for i in reversed(range(len(rhs))):
            carry = rhs[i]
            if i + 1 < len(rhs):
                carry = carry.copy()
                carry[self.top :] -= self.coupling[i] @ out[i + 1, : self.over]
            out[i], _ = dtrtrs(self.lower[i], carry, lower=1, trans=1)
        return out

    def solve(self, rhs: Array) -> Array:
        """Return N^-1 rhs for rhs (m, b, r)."""
        return self.backward(self.forward(rhs))

    def inverse(self) -> Iterator[tuple[Array, Array]]:
        """Yield the blocks of N^-1, the last first: on its diagonal (b, b), and what the band has right of it (c, c).

        Takahashi's recursion; nobody needs all of them at once.
        """
        count, over, top = len(self.lower), self.over, self.top
        after = np.zeros(0)
        for i in reversed(range(count)):
            inverse, _ = dtrtri(self.lower[i], lower=1)
            own = inverse.T @ inverse
            right = np.zeros((over, over))
            if i + 1 < count and over:
                gain = inverse[top:].T @ self.coupling[i]
                whole = -gain @ after[:over, :over]
                own -= whole @ gain.T
                right = whole[top:]
            yield own, right
            after = own


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

        All columns are solved at once: what a solve costs beside its arithmetic is paid once.
        """
        (m, b, r, d), p = g.shape, len(h)
        front = self.factor.forward(g.reshape(m, b, r * d))
        out = c - _inner(front.reshape(m * b, r, d), front.reshape(m * b, r, d))
        if p:
            rest = h.reshape(p, r * d) - tensor(self.half, front)
            solved = np.asarray(np.linalg.solve(self.schur, rest), dtype=float)
            out = out - _inner(rest.reshape(p, r, d), solved.reshape(p, r, d))
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
