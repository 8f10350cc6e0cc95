"""Block-tridiagonal matrices: how a long fit stays linear in its length.

Knots are gathered into blocks; a measurement touches at most two neighbouring ones.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtri, dtrtrs

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA


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
    for ridge in ALGEBRA.ridges:
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
