"""Intervals of a quantile and of a share, from a few recordings and without a law of their errors."""

import numpy as np
from scipy import stats

from imubench.arrays import Array

CONFIDENCE = 0.95


def quantile(errors: Array, q: float) -> float:
    """Return a quantile of errors (n,), linear between neighbours; an infinite one stands for no answer.

    NaN of none.
    """
    if not errors.size:
        return float("nan")
    ordered = np.sort(errors)
    at = (errors.size - 1) * q
    low, part = int(at), at - int(at)
    if part == 0.0 or not np.isfinite(ordered[low]):
        return float(ordered[low])
    return float(ordered[low] + part * (ordered[low + 1] - ordered[low]))  # inf where the next one is


def quantile_interval(errors: Array, q: float, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Return an interval that holds the quantile of what errors (n,) are drawn from, whatever their law.

    The ends are two of the errors (order statistics): how many of n lie below the quantile is binomial. 0 or infinity
    is an end where n is too small for one. (David, Nagaraja, Order Statistics, 3rd ed., section 7.1.)
    """
    n, ordered = errors.size, np.sort(errors)
    if not n:
        return 0.0, float("inf")
    tail = (1.0 - confidence) / 2.0
    below = stats.binom.cdf(np.arange(n), n, q)  # of k: that at most k of n lie below
    # The r-th smallest lies above the quantile where at most r - 1 lie below it.
    low = int(np.searchsorted(below, tail, side="right"))  # the largest r for which that is unlikely
    high = int(np.searchsorted(below, 1.0 - tail, side="left")) + 1  # the smallest s for which it is likely
    return (float(ordered[low - 1]) if low else 0.0), (float(ordered[high - 1]) if high <= n else float("inf"))


def share_interval(hits: int, n: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Return the interval of Clopper and Pearson (Biometrika 26, 1934) of a share; 0 and 1 of none."""
    tail = (1.0 - confidence) / 2.0
    low = float(stats.beta.ppf(tail, hits, n - hits + 1)) if hits else 0.0
    high = float(stats.beta.ppf(1.0 - tail, hits + 1, n - hits)) if hits < n else 1.0
    return low, high
