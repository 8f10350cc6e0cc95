"""Few splines solved alone: a narrow band, which LAPACK solves faster as such than block by block."""

from contextlib import suppress

import numpy as np
from scipy.linalg import solveh_banded

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.bspline import SUPPORT, Tracks
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.normal_equations import Normal


def solved(normal: Normal, rhs: Array) -> Array:
    """Return x (m, b, r) of the splines' own equations for right-hand sides (m, b, r).

    `NotPositiveDefiniteError` where nothing holds a spline.
    """
    (m, b, _), c = normal.diagonal.shape, normal.right.shape[1]
    below = np.zeros((SUPPORT * (b // ALGEBRA.knots_per_block), m, b))  # [d, block, column]: d rows under the diagonal
    for d, own in enumerate(below):
        if d < b:
            column = np.arange(b - d)
            own[:, column] = normal.diagonal[:, column + d, column]
        row = np.arange(max(c - d, 0), min(2 * c - d, c))  # of those that the next block has
        own[:-1, b - c + row] = normal.right[:-1, row, row + d - c]
    rhs_flat, diagonal = rhs.reshape(m * b, -1), below[0].copy()
    for ridge in ALGEBRA.ridges:
        below[0] = diagonal * (1 + ridge)
        with suppress(np.linalg.LinAlgError):
            x = solveh_banded(below.reshape(-1, m * b), rhs_flat, lower=True, check_finite=False)
            return np.asarray(x).reshape(rhs.shape)
    raise NotPositiveDefiniteError("splines alone")


def eased(only: Tracks, rows: list[Rows], damping: float) -> Array:
    """Return the Gauss-Newton step (knots or more, width) of some splines alone, their diagonal raised by a share."""
    normal = Normal.empty(only, Parameters({}))
    normal.add([linearise(r, only, Parameters({})) for r in rows])
    normal.fill(only, damping)
    return solved(normal, -normal.gradient[:, :, None]).reshape(-1, only.width)


__all__ = ["eased", "solved"]
