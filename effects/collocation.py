"""What a spring's frequency in continuous time is where its law is held in the middle of every interval of a spline.

A fit has x(t) = sum_j c_j B(t / h - j), B quintic, and asks for x'' + 2 z w x' + w^2 x = drive in the middle of every
interval of h s. A wave of v rad/s has c_j = exp(i v h j), and there

    D_k(v) = sum_j B^(k)(1/2 + j) exp(-i v h j) / h^k,    -D_2 / D_0 = (r v)^2,  r -> 1 as h -> 0

so the spring resonates at the v with r(v) v = w. A spring of w in time is found as r(w) w: at seven knots a period by
0.05 % too low, at four by 0.6 %, at three by 2.5 %. Its damping ratio is found as it is, to some percent: the resonance
is as high and as wide. MuJoCo integrates the law in time.
"""

from functools import cache

import numpy as np
from scipy.interpolate import BSpline

from imubench.arrays import Array

DEGREE = 5  # of the splines that motions are fitted with
COARSEST = 2.35  # knots a period: with fewer r(v) v grows by less than half of v, and a number's error is doubled
ROUNDS = 60  # of a fixed point that contracts by a half or less a round


@cache
def middle_weights() -> Array:
    """Return B and B'' (2, 6) in the middle of each of its intervals."""
    basis = BSpline.basis_element(np.arange(DEGREE + 2.0))
    places = 0.5 + np.arange(DEGREE + 1)
    return np.stack([basis(places), basis.derivative(2)(places)])


def collocated(frequency: Array, step: float) -> Array:
    """Return the frequencies (k,) Hz in a fit with knots `step` s apart of springs that have these in time.

    As they are where there are fewer than `COARSEST` knots a period: so quick springs only give way, by 1 / w^2.
    """
    shown = np.minimum(frequency, 1 / (COARSEST * step))
    waves = np.exp(-2j * np.pi * step * np.outer(np.arange(DEGREE + 1), shown))
    value, second = middle_weights() @ waves
    found = np.sqrt(-(second / value).real) / (2 * np.pi * step)
    return np.asarray(np.where(shown < frequency, frequency, found))


def in_time(frequency: Array, step: float) -> Array:
    """Return the frequencies (k,) Hz in time of springs that have these in a fit with knots `step` s apart.

    One that is found between what is found of `COARSEST` knots a period and that itself has these; one above is as it
    is.
    """
    most = 1 / (COARSEST * step)
    found = np.minimum(frequency, most)
    for _ in range(ROUNDS):
        found = np.minimum(found * frequency / collocated(found, step), most)
    return np.asarray(np.where(frequency > most, frequency, found))


__all__ = ["collocated", "in_time"]
