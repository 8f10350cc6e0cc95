"""Whether two sensors' readings have anything in common, told on data that the combination was not learnt from.

Two sensors of one mechanism share numbers that no calibration changes: what a hinge's segments turn across its axis,
say. Which combination of each one's signals that is follows from the data (canonical correlation, Hotelling 1936), so
neither mounts nor scales nor biases need be known. Learnt on three quarters of the blocks it is correlated on the
fourth: sensors that share a motion come near 1 there, sensors that share none near 0, whatever their spectra.

How near to 0 chance comes is not assumed: it is seen with the second sensor's readings turned round in time, which
leaves its spectrum and takes away what was common.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.nonsense import SHARED_MOTION
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.config.solve import START

MOST_LAG_S = SHARED_MOTION.lag_step_s * int(START.most_offset_s / SHARED_MOTION.lag_step_s)
"""Seconds by which clocks may be apart: whole steps, as far as a diagnosis looks for an offset."""


@dataclass(frozen=True)
class Shared:
    """What two sensors' readings have in common."""

    correlation: float  # on data that it was not learnt from, at the best lag
    beyond: float  # standard deviations by which its z = artanh(correlation) is above that of surrogates

    @property
    def unrelated(self) -> bool:
        """Return whether there is no more in common than chance brings about, and less than any one motion leaves."""
        return self.correlation < SHARED_MOTION.alike and self.beyond < STATISTICS.clear_sigmas


def shared(one: Array, two: Array, step: float) -> Shared | None:
    """Return what signals (n, p) and (n, q) on one grid of `step` s have in common; none where they are too short."""
    most, apart = round(MOST_LAG_S / step), round(SHARED_MOTION.surrogate_s / step)
    n = len(one)
    if (
        n < 2 * (most + apart) or n * step < SHARED_MOTION.folds * SHARED_MOTION.blocks
    ):  # s: a block is no shorter than a stroke
        return None
    found = at_lags(one, two, most, step)
    if found >= SHARED_MOTION.alike:
        return Shared(found, np.inf)
    turns = np.linspace(apart, n - apart, SHARED_MOTION.surrogates).astype(int)
    others = np.array([at_lags(one, np.roll(two, turn, axis=0), most, step) for turn in turns])
    most_like = 1 - SHARED_MOTION.ridge  # the ridge keeps what was learnt from meaning more
    z, chance = (np.arctanh(np.clip(x, -most_like, most_like)) for x in (found, others))
    return Shared(found, float((z - chance.mean()) / max(float(chance.std()), 1e-6)))


def at_lags(one: Array, two: Array, most: int, step: float) -> float:
    """Return the largest held-out correlation of two signals over all lags up to `most` samples."""
    every = max(1, round(SHARED_MOTION.lag_step_s / step))
    first = one[most : len(one) - most]
    lags = range(-(most // every) * every, most + 1, every)
    return max(held_out(first, two[most + k : len(two) - most + k]) for k in lags)


def held_out(one: Array, two: Array) -> float:
    """Return the correlation of the first canonical pair of signals (n, p) and (n, q) on parts left out in turn."""
    p = one.shape[1]
    both = np.concatenate([one, two, np.ones((len(one), 1))], axis=1)  # the ones hold the sums beside the products
    edges = np.linspace(0, len(both), SHARED_MOTION.folds * SHARED_MOTION.blocks + 1).astype(int)
    products = np.array([both[a:b].T @ both[a:b] for a, b in pairwise(edges)])
    parts = products.reshape(SHARED_MOTION.blocks, SHARED_MOTION.folds, *products.shape[1:]).sum(axis=0)
    total = np.zeros(3)  # of a b, a a, b b
    for left in parts:
        learnt = parts.sum(axis=0) - left
        mean = learnt[-1, :-1] / learnt[-1, -1]
        a, b = canonical(learnt[:-1, :-1] / learnt[-1, -1] - np.outer(mean, mean), p)
        about = left[:-1, :-1] - np.outer(left[-1, :-1], mean) - np.outer(mean, left[-1, :-1])
        about = about + left[-1, -1] * np.outer(mean, mean)
        total += [a @ about[:p, p:] @ b, a @ about[:p, :p] @ a, b @ about[p:, p:] @ b]
    power = float(np.sqrt(total[1] * total[2])) if min(total[1:]) > 0 else 0.0
    return float(total[0]) / power if power > 0 else 0.0


def canonical(covariance: Array, p: int) -> tuple[Array, Array]:
    """Return the weights (p,) and (q,) with which the first p signals and the rest correlate most; (p + q, p + q)."""
    roots = [np.linalg.cholesky(_firm(x)) for x in (covariance[:p, :p], covariance[p:, p:])]
    between = np.linalg.solve(roots[0], np.linalg.solve(roots[1], covariance[p:, :p]).T)
    left, _, right = np.linalg.svd(between)
    return np.linalg.solve(roots[0].T, left[:, 0]), np.linalg.solve(roots[1].T, right[0])


def _firm(own: Array) -> Array:
    return own + (SHARED_MOTION.ridge * np.trace(own) / len(own) + 1e-12) * np.eye(len(own))


def squares(rate: Array) -> Array:
    """Return the products of every two components of rates (n, 3), and the components, of unit size: (n, 9).

    |w x j|^2, the square of what a sensor turns across an axis j of its own, is a sum of the products, whatever j is;
    the components take in a bias.
    """
    w = rate / max(float(np.sqrt(np.mean(rate**2))), 1e-12)
    pairs = [w[:, i] * w[:, j] for i in range(3) for j in range(i, 3)]
    return np.stack([*pairs, *w.T], axis=1)


__all__ = ["Shared", "held_out", "shared", "squares"]
