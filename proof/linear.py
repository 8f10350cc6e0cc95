"""Linear equations of motion whose coefficients change with time: x' = A(t) x + b(t), on the fine grid."""

import numpy as np

from imubench.proof.rotation import Array

CHUNK = 20_000


def middles(x: Array) -> Array:
    """Return grid values (n, ...) half-way between the points, (n - 1, ...), by cubics through four points."""
    y = np.concatenate([[3 * x[0] - 3 * x[1] + x[2]], x, [3 * x[-1] - 3 * x[-2] + x[-3]]])
    return np.asarray((9 * (y[1:-2] + y[2:-1]) - y[:-3] - y[3:]) / 16)


def solve(A: Array, b: Array, x0: Array, step: float) -> Array:
    """Return x (n, k) of A (n, k, k), b (n, k) from x0 (k,), by Runge and Kutta's fourth-order rule.

    Every step is one affine map, made for all steps at once; only their product is taken one by one.
    """
    n, k = b.shape
    x = np.empty((n, k))
    x[0] = x0
    one = np.eye(k)
    for first in range(0, n - 1, CHUNK):
        part = slice(first, min(first + CHUNK, n - 1) + 1)
        A0, b0 = A[part], b[part]
        Am, bm, A0, A1, b0, b1 = middles(A0), middles(b0), A0[:-1], A0[1:], b0[:-1], b0[1:]
        K2, c2 = Am @ (one + step / 2 * A0), _apply(Am, step / 2 * b0) + bm
        K3, c3 = Am @ (one + step / 2 * K2), _apply(Am, step / 2 * c2) + bm
        K4, c4 = A1 @ (one + step * K3), _apply(A1, step * c3) + b1
        M = one + step / 6 * (A0 + 2 * K2 + 2 * K3 + K4)
        c = step / 6 * (b0 + 2 * c2 + 2 * c3 + c4)
        for i in range(len(M)):
            x[first + i + 1] = M[i] @ x[first + i] + c[i]
    return x


def _apply(A: Array, x: Array) -> Array:
    return np.einsum("nij,nj->ni", A, x)
