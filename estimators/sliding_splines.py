"""The two kinds of splines behind `sliding`: those that multiply its equations, and those that smooth its rates.

Both depend on how many samples there are and how far apart, not on what they read. So a stream, whose windows are
alike, builds them once: `Basis.even` keeps the last ones.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.linalg import cholesky_banded, lapack, toeplitz

from imubench.arrays import Array
from imubench.errors import InputError

KNOTS = 0.04  # s between splines that multiply: passes half of the amplitude at 9 Hz
SPACINGS = (0.5, 0.35, 0.25, 0.18, 0.125, 0.09, 0.0625, 0.045)  # s between knots of the smoothed rates
DEGREE = 7  # so that the fourth derivative is smooth too
MOST = 4000  # samples whose splines are kept for the next window: 8 s at 500 Hz, 10 MB
EVEN = 1e-6  # steps off an even grid: 1e-8 s at 100 Hz, in which no rate changes by what a gyroscope resolves


def rounded(step: float) -> float:
    """Return a step in s to ten digits, in which windows of one stream agree."""
    return float(f"{step:.10g}")


def even_times(count: int, step: float) -> Array:
    """Return `count` times in s, `step` s apart from 0 s on."""
    return step * np.arange(count, dtype=float)


def stencil(step: float) -> tuple[int, Array, Array]:
    """Return m samples `step` s from knot to knot, b and -b' (4 m - 1,) of one cubic B-spline; b sums to 1."""
    m = max(2, round(KNOTS / step))
    u = (np.arange(1, 4 * m) - 2 * m) / m
    s = np.abs(u)
    value = np.where(s < 1, 2 / 3 - s**2 + s**3 / 2, (2 - s) ** 3 / 6) / m
    slope = np.sign(u) * np.where(s < 1, -2 * s + 1.5 * s**2, -((2 - s) ** 2) / 2) / (m * m * step)
    return m, value, -slope


@lru_cache(maxsize=4)
def splines(count: int, step: float) -> tuple[Any, Any]:
    """Return b and -b' (rows, count) at even samples `step` s apart, as sparse matrices."""
    m, value, minus = stencil(step)
    starts = np.arange(0, count - value.size + 1, m)
    columns = (starts[:, None] + np.arange(value.size)).ravel()
    ends = np.arange(starts.size + 1) * value.size
    shape = (starts.size, count)
    b, slopes = (sparse.csr_matrix((np.tile(x, starts.size), columns, ends), shape=shape) for x in (value, minus))
    return b, slopes


def noise_of_sums(count: int, step: float) -> Array:
    """Return b b^T (rows, rows): the covariance of sums with b of white noise of size 1."""
    m, value, _ = stencil(step)
    rows = (count - value.size) // m + 1
    lags = [float(value[: value.size - i * m] @ value[i * m :]) if i < 4 else 0.0 for i in range(rows)]
    return np.asarray(toeplitz(lags))


def inverse_root(V: Array) -> Array:
    """Return L^-1 of a symmetric positive definite V = L L^T."""
    L, failed = lapack.dpotrf(V, lower=1, clean=1)
    if failed:
        raise np.linalg.LinAlgError("the noise's covariance is not positive definite")
    return np.asarray(lapack.dtrtri(L, lower=1, overwrite_c=1)[0])


@dataclass(frozen=True)
class Basis:
    """Splines of degree 7 over some samples, to be fitted to them by least squares."""

    knots: Array  # s
    design: Any  # (n, k), sparse: each spline at each sample
    across: Any  # (k, n), the same transposed
    factor: Array  # (8, k), the banded Cholesky factor of design^T design, lower

    @classmethod
    def over(cls, time: Array, spans: int) -> "Basis":
        """Return splines over samples at `time` (n,) s, their knots in `spans` even steps from first to last."""
        inner = np.linspace(time[0], time[-1], spans + 1)
        knots = np.concatenate([np.full(DEGREE, time[0]), inner, np.full(DEGREE, time[-1])])
        design = BSpline.design_matrix(time, knots, DEGREE)
        across = design.T.tocsr()
        normal = (across @ design).toarray()
        band = np.zeros((DEGREE + 1, len(normal)))
        for i in range(DEGREE + 1):
            band[i, : len(normal) - i] = np.diagonal(normal, -i)
        return cls(knots, design, across, cholesky_banded(band, lower=True, check_finite=False))

    @classmethod
    def even(cls, count: int, step: float, spans: int) -> "Basis":
        """Return splines over `count` samples `step` s apart from 0 s on."""
        return _kept(count, step, spans) if count <= MOST else cls.over(even_times(count, step), spans)

    def fitted(self, samples: Array) -> BSpline:
        """Return the splines that come closest to samples (n, 3)."""
        sizes, _ = lapack.dpbtrs(self.factor, self.across @ samples, lower=1)
        return BSpline.construct_fast(self.knots, np.ascontiguousarray(sizes), DEGREE)

    @cached_property
    def kept(self) -> Array:
        """What fitting keeps of white noise of size 1 in one axis, -b' applied: its covariance (rows, rows)."""
        n = self.design.shape[0]
        slopes = (splines(n, rounded((self.knots[-1] - self.knots[0]) / (n - 1)))[1] @ self.design).toarray()
        L = np.linalg.cholesky((self.across @ self.design).toarray())
        left = lapack.dtrtrs(L, slopes.T, lower=1)[0]
        return np.asarray(left.T @ left)


@lru_cache(maxsize=32)
def _kept(count: int, step: float, spans: int) -> Basis:
    return Basis.over(even_times(count, step), spans)


@dataclass(frozen=True)
class Smoothed:
    """Rates as splines, of the density that Bayes' information criterion chose."""

    spline: BSpline  # of s since the first sample, in rad/s
    basis: Basis
    density: int  # the place of the knots' spacing in SPACINGS


def smoothed(time: Array, gyro: Array, densities: range = range(len(SPACINGS))) -> Smoothed:
    """Return rates (n, 3) in rad/s at `time` (n,) s as splines of degree 7, of one of some densities.

    Raises `InputError` for samples too far apart for any, which takes two to a spline.
    """
    n, since = time.size, time - time[0]
    step = rounded(since[-1] / (n - 1))
    even = float(np.abs(since - even_times(n, step)).max()) < EVEN * step
    if even:
        since = even_times(n, step)
    least, found = np.inf, None
    for i, spacing in enumerate(SPACINGS):
        spans = max(2, round(since[-1] / spacing))
        if spans + DEGREE > n // 2:
            break
        if i not in densities:
            continue
        basis = Basis.even(n, step, spans) if even else Basis.over(since, spans)
        spline = basis.fitted(gyro)
        left = np.maximum(np.sum((gyro - basis.design @ spline.c) ** 2, axis=0), 1e-12 * n).sum()
        criterion = 3 * n * np.log(left) + 3 * (spans + DEGREE) * np.log(3 * n)
        if criterion < least:
            least, found = criterion, Smoothed(spline, basis, i)
    if found is None and len(densities) < len(SPACINGS):
        return smoothed(time, gyro)
    if found is None:
        raise InputError(f"sliding: expected samples {SPACINGS[0] / 4:g} s apart or closer, got {step:g} s")
    return found
