"""What a spring's law, held in the middle of every interval of a quintic spline, is as a law in continuous time.

A fit has x(t) = sum_j c_j B(t / h - j) and asks for x'' + 2 z w x' + w^2 x = drive in the middle of every interval of
h s. With c_j = exp(s h j) and the derivatives there, D_k(s) = sum_j B^(k)(1/2 + j) exp(-s h j) / h^k, it rings freely
where

    a_2 + 2 z w a_1 + w^2 = 0,    a_k = D_k / D_0

of which a_1 -> s and a_2 -> s^2 as h -> 0. So a spring of frequency f and damping ratio z in time, which rings with the
pole s = 2 pi f (-z + i sqrt(1 - z^2)), has in the fit 2 z w = -Im a_2 / Im a_1 and w^2 = -Re a_2 - 2 z w Re a_1. At
seven knots a period that is a frequency lower by 0.05 %, at four by 0.6 %, at three by 2.5 %, and less damping: what is
0.050 at 3.2 knots a period is 0.058 in time. MuJoCo integrates the law in time.
"""

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
from scipy.interpolate import BSpline

from imubench.arrays import Array

DEGREE = 5  # of the splines that motions are fitted with
COARSEST = 2.2  # knots a period: with fewer a wave is its alias, and no numbers in time ring so
OVERDAMPED = 0.99  # the damping ratio above which nothing rings, and numbers stay as they are
TINY = 1e-9  # of a frequency in Hz and a damping ratio, whose logarithms are taken
ROUNDS = 30  # of a fixed point that contracts by 0.1 or less a round


@cache
def middle_weights() -> Array:
    """Return B, B' and B'' (3, 6) in the middle of each of its intervals."""
    basis = BSpline.basis_element(np.arange(DEGREE + 2.0))
    places = 0.5 + np.arange(DEGREE + 1)
    return np.stack([basis(places), basis.derivative(1)(places), basis.derivative(2)(places)])


def collocated(frequency: float, damping: float, step: float) -> tuple[float, float]:
    """Return the frequency and damping ratio in a fit with knots `step` s apart of a spring that has these in time."""
    if damping >= OVERDAMPED:
        return frequency, damping
    pole = 2 * np.pi * frequency * step * (-damping + 1j * np.sqrt(1 - damping**2))
    waves = middle_weights() @ np.exp(-pole * np.arange(DEGREE + 1))
    first, second = waves[1] / waves[0], waves[2] / waves[0]
    loss = -second.imag / first.imag
    square = -second.real - loss * first.real
    if not square > 0:
        return frequency, damping
    return float(np.sqrt(square) / (2 * np.pi * step)), float(loss / (2 * np.sqrt(square)))


def in_time(frequency: float, damping: float, step: float) -> tuple[float, float]:
    """Return the frequency and damping ratio in time of a spring that has these in a fit with knots `step` s apart.

    Those nearest where the fit has fewer than `COARSEST` knots a period.
    """
    f, z, most = frequency, damping, 1 / (COARSEST * step)
    if f > most or z >= OVERDAMPED:
        return frequency, damping
    for _ in range(ROUNDS):
        had = collocated(f, z, step)
        f, z = min(f * frequency / had[0], most), float(np.clip(z + damping - had[1], 0.0, OVERDAMPED))
    return f, z


Way = Callable[[float, float, float], tuple[float, float]]


def springs(values: Mapping[str, Array], step: float, way: Way) -> dict[str, Array]:
    """Return an effect's numbers as a fit has them, with `frequency` and `damping_ratio` (logarithms) of another law.

    Args:
        values: frequencies (k,) and damping ratios (k or 1,), besides others. One ratio of several springs becomes
            their geometric mean.
        step: s between knots.
        way: `collocated` or `in_time`.
    """
    frequency, damping = (np.exp(values[name]) for name in ("frequency", "damping_ratio"))
    pairs = [way(float(f), float(z), step) for f, z in zip(frequency, np.resize(damping, frequency.size), strict=True)]
    other = np.log(np.maximum(pairs, TINY))
    ratio = other[:, 1] if damping.size == frequency.size else np.full(damping.size, other[:, 1].mean())
    return {**values, "frequency": other[:, 0], "damping_ratio": ratio}


__all__ = ["collocated", "in_time", "springs"]
