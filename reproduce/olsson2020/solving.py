"""Algorithm 1 from many starts on the same samples, and Algorithm 4 on many runs at once."""

import math

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.estimators.hinge_constraints import Constraints
from imubench.estimators.hinge_fit import Solution, descend
from imubench.estimators.olsson2020 import TOLERANCE
from imubench.estimators.spherical import opposite
from imubench.estimators.uncertainty import local_uncertainty, paper_covariance
from imubench.reproduce.olsson2020.settings import DRAWS
from imubench.rotations import angle_between

SAME = 1e-6  # rad; minima this close are one, 1000 times closer than the noise places them


class Minima:
    """Algorithm 1 on one set of samples, from one start after the other.

    Its second descent begins where the first one ended. So starts whose first descent ends in the same
    minimum share the rest: the second descent, the choice between both, and the local uncertainty.
    """

    def __init__(self, c: Constraints, draws: np.random.Generator):
        self._c, self._draws = c, draws
        self._known: list[tuple[Array, Solution, Array]] = []  # first minimum, answer, its mu_z + 2 sigma_z

    def estimate(self, start: Array) -> tuple[Array, Array]:
        """Return the axes (2, 3) that Algorithm 1 finds from `start`, and their mu_z + 2 sigma_z (2,) in rad."""
        first = descend(self._c, start, TOLERANCE)
        for axes, answer, local in self._known:
            sign = math.copysign(1.0, float(axes[0] @ first.axes[0]))
            if float(np.abs(sign * axes - first.axes).max()) < SAME:
                return sign * answer.axes, local
        second = descend(self._c, opposite(first.x), TOLERANCE)
        answer = first if first.cost <= second.cost else second
        local = local_uncertainty(paper_covariance(answer), self._draws, DRAWS)
        self._known.append((first.axes, answer, local))
        return answer.axes, local


def sequential_deviations(axes: Array) -> Array:
    """Return SEQAD (t, m) in rad, eq. (66) and (67), of estimates (t, m, 2, 3): m runs side by side."""
    seqad = np.full(axes.shape[:2], math.pi)
    previous = axes[0]
    for t in range(1, len(axes)):
        same, turned = angle_between(axes[t], previous), angle_between(-axes[t], previous)  # (m, 2)
        flip = turned.min(axis=-1) < same.min(axis=-1)
        seqad[t] = np.where(flip[:, None], turned, same).max(axis=-1)
        previous = np.where(flip[:, None, None], -axes[t], axes[t])
    return seqad


def worst_of_last(seqad: Array, n_min: int) -> Array:
    """Return the largest of the last `n_min` SEQADs (t, m), eq. (68); before the first estimate it was 180 deg."""
    padded = np.concatenate([np.full((n_min - 1, seqad.shape[1]), math.pi), seqad])
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, n_min, axis=0).max(axis=-1))


def acceptance(seqad: Array, local: Array, e_max: float, n_min: int) -> NDArray[np.int_]:
    """Return for each run the index (m,) of the first estimate that Algorithm 4 accepts, -1 for none.

    `seqad` (t, m) and `local` (t, m, 2), mu_z + 2 sigma_z, in rad.
    """
    good = (worst_of_last(seqad, n_min) < e_max) & (local < e_max).all(axis=-1)
    return np.where(good.any(axis=0), good.argmax(axis=0), -1)
