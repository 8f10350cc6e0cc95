"""What all forms of Algorithm 3 share: the order of removal, the coherence, and one removal as printed."""

import numpy as np

from imubench.arrays import Array
from imubench.estimators.selection_gyro import Index


def removal_order(penalty: Array) -> Index:
    """Return the indices (m,) by falling penalty; of equal penalties the latest sample comes first."""
    return np.argsort(penalty, kind="stable")[::-1]


def directions(rows: Array) -> Array:
    """Return rows (m, 6) at unit length; a row of zeros, whose coherence eq. (52) leaves undefined, stays zero."""
    norms = np.sqrt(np.einsum("ij,ij->i", rows, rows))
    return np.asarray(rows / np.where(norms > 0, norms, 1.0)[:, None])


def coherence(rows: Array, direction: Array) -> Array:
    """Return c (m,), eq. (52), of rows (m, 6) with a unit direction (6,)."""
    return np.asarray(np.abs(directions(rows) @ direction))


def choose(rows: Array, penalty: Array) -> int:
    """Return the index of the row that Algorithm 3 removes next, by a singular value decomposition of rows (m, 6).

    It is the row of largest penalty among those with c > 0.5. If there is none, which the paper leaves open,
    no direction has rows to spare, and the largest penalty of all decides.
    """
    strongest = np.linalg.svd(rows, full_matrices=False)[2][0]
    coherent = np.flatnonzero(coherence(rows, strongest) > 0.5)
    if not coherent.size:
        coherent = np.arange(len(rows))
    return int(coherent[removal_order(penalty[coherent])[0]])
