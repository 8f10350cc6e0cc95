"""Block-tridiagonal matrices with a dense border: how a long fit stays linear in its length.

Knots are gathered into blocks; a measurement touches at most two neighbouring ones. The few
numbers that the whole recording shares (geometry, effects) are the border::

    [ N   B ] [ x ]   [ g ]
    [ B'  C ] [ p ] = [ h ]
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri, dtrtrs

from imubench.arrays import Array

RIDGES = (0.0, 1e-13, 1e-12)  # of a block's diagonal: what rounding may take from it, where it did


class NotPositiveDefiniteError(ArithmeticError):
    """A direction that neither a measurement nor a prior holds."""


@dataclass(frozen=True)
class Banded:
    """A symmetric block-tridiagonal matrix: diagonal and right neighbours, both (m, b, b), the last of these unused."""

    diagonal: Array
    right: Array

    def factor(self) -> "Factor":
        """Return its Cholesky factor; `NotPositiveDefiniteError` names the block."""
        count = len(self.diagonal)
        lower, coupling = by_columns(self.diagonal.shape), by_columns(self.right.shape)
        top, over = self.coupled
        rest = self.diagonal[0]
        for i in range(count):
            chol = _cholesky(rest)
            if chol is None:
                raise NotPositiveDefiniteError(f"block {i} of {count}")
            lower[i] = chol
            if i + 1 < count:
                z, _ = dtrtrs(chol[top:, top:], self.right[i, top:, :over], lower=1)
                coupling[i, top:, :over] = z
                rest = self.diagonal[i + 1].copy()
                rest[:over, :over] -= z.T @ z
        return Factor(lower, coupling, top, over)

    @property
    def coupled(self) -> tuple[int, int]:
        """The first row and the column after the last one that any block on the right has: a band's far corner."""
        rows, columns = (np.flatnonzero(self.right.any(axis=axes)) for axes in ((0, 2), (0, 1)))
        return (int(rows[0]), int(columns[-1]) + 1) if len(rows) else (0, 0)

    def times(self, x: Array) -> Array:
        """Return N x for x (m, b, r)."""
        out = np.matmul(self.diagonal, x)
        out[:-1] += np.matmul(self.right[:-1], x[1:])
        out[1:] += np.matmul(np.swapaxes(self.right[:-1], 1, 2), x[:-1])
        return out


def _cholesky(matrix: Array) -> Array | None:
    """Return a matrix' lower factor, where it has none the one of a matrix that rounding cannot tell from it."""
    for ridge in RIDGES:
        chol, info = dpotrf(matrix + ridge * np.diag(np.diagonal(matrix)) if ridge else matrix, lower=1, clean=1)
        if not info:
            return np.asarray(chol)
    return None


@dataclass(frozen=True)
class Factor:
    """N = L L' with L block-bidiagonal: `lower` (m, b, b) and Z_i = L_i^-1 N_i,i+1 (m, b, b)."""

    lower: Array
    coupling: Array
    top: int  # Z has nothing above this row,
    over: int  # nor from this column on

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
                carry[: self.over] -= self.coupling[i, self.top :, : self.over].T @ out[i, self.top :]
        return out

    def backward(self, rhs: Array) -> Array:
        """Return L'^-1 rhs for rhs (m, b, r)."""
        out = np.empty_like(rhs)
        for i in reversed(range(len(rhs))):
            carry = rhs[i]
            if i + 1 < len(rhs):
                carry = carry.copy()
                carry[self.top :] -= self.coupling[i, self.top :, : self.over] @ out[i + 1, : self.over]
            out[i], _ = dtrtrs(self.lower[i], carry, lower=1, trans=1)
        return out

    def solve(self, rhs: Array) -> Array:
        """Return N^-1 rhs for rhs (m, b, r)."""
        return self.backward(self.forward(rhs))

    def inverse(self) -> Banded:
        """Return the blocks of N^-1 on and right of its diagonal (Takahashi's recursion)."""
        count = len(self.lower)
        diagonal, right = np.empty(self.lower.shape), np.zeros(self.coupling.shape)
        for i in reversed(range(count)):
            own, _ = dpotri(self.lower[i], lower=1)
            own = np.tril(own) + np.tril(own, -1).T
            if i + 1 < count:
                gain, _ = dtrtrs(self.lower[i], self.coupling[i, :, : self.over], lower=1, trans=1)
                right[i] = -gain @ diagonal[i + 1, : self.over]
                own -= right[i, :, : self.over] @ gain.T
            diagonal[i] = own
        return Banded(diagonal, right)


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
    """Factor the arrow matrix of `band`, border (m, b, p) and corner (p, p)."""
    factor = band.factor()
    half = factor.forward(border) if border.shape[2] else border
    return Solution(factor, border, half, corner - tensor(half, half))


def by_columns(shape: tuple[int, ...]) -> Array:
    """Return zeros (m, b, b), every block laid out by its columns as LAPACK wants it."""
    return np.zeros((shape[0], shape[2], shape[1])).transpose(0, 2, 1)


def tensor(a: Array, b: Array) -> Array:
    """Return A' B of block columns (m, b, p) and (m, b, r)."""
    rows = a.shape[0] * a.shape[1]
    return a.reshape(rows, a.shape[2]).T @ b.reshape(rows, b.shape[2])


def _inner(a: Array, b: Array) -> Array:
    """Return the sum (r, q) over rows and draws of the products of a (n, r, d) and b (n, q, d)."""
    return np.asarray(np.tensordot(a, b, axes=((0, 2), (0, 2))))
