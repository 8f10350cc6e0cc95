"""Which gyroscope samples tell most about a hinge: Olsson 2020, Algorithm 2."""

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array

Index = NDArray[np.intp]

HALF_WIDTH = 10
"""n of eq. (44) and (45): 2 n + 1 = 21 samples, the 0.42 s at 50 Hz of section 7.3."""


def squared_norms(vectors: Array) -> Array:
    """Return the squared norms (n,) of vectors (n, 3), each rounded alike wherever it stands."""
    x, y, z = vectors.T
    return np.asarray(x * x + y * y + z * z)


def rate_differences(gyro1: Array, gyro2: Array) -> Array:
    """Return ||w1|| - ||w2|| (n,) in rad/s, eq. (42), from gyro (n, 3) in rad/s."""
    return np.asarray(np.sqrt(squared_norms(gyro1)) - np.sqrt(squared_norms(gyro2)))


def gyro_scores(differences: Array, half_width: int = HALF_WIDTH) -> Array:
    """Return for each sample the difference (n,) of smallest magnitude around it, eq. (43) and (44).

    The window is `half_width` samples to either side, cut off at the ends of the record; of equal
    magnitudes the earliest counts. Windows of 1, 2, 4, ... samples are put together from two halves.
    """
    width = 2 * half_width + 1
    best = np.pad(differences, half_width, constant_values=np.inf)
    span = 1
    while 2 * span <= width:
        best = _smaller(best[:-span], best[span:])
        span *= 2
    rest = width - span
    return _smaller(best[:-rest], best[rest:]) if rest else best


def _smaller(earlier: Array, later: Array) -> Array:
    return np.where(np.abs(earlier) <= np.abs(later), earlier, later)


def pick_gyro(scores: Array, n_max: int) -> Index:
    """Return the indices (<= n_max,), ascending, of the largest and the smallest scores (Algorithm 2).

    Half of `n_max` from either end of the order by score; an odd one comes from the large end. Of equal
    scores the earlier sample stands nearer to the large end.
    """
    if scores.size <= n_max:
        return np.arange(scores.size)
    order = np.argsort(-scores, kind="stable")
    large, small = n_max - n_max // 2, n_max // 2
    return np.sort(np.concatenate([order[:large], order[scores.size - small :]]))
