"""Smooth functions of time with exact first and second derivatives."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, PPoly

from imubench.arrays import Array
from imubench.errors import InputError

Signal = Callable[[Array], tuple[Array, Array, Array]]
"""Takes times (n,) in s; returns value, first and second derivative, each (n,).

A signal that is not defined for all time raises `InputError` beyond its own (`check_within`), so that every motion made
of it does: polynomials left to themselves grow with the fifth power of time.
"""

AROUND = 0.01  # s that a signal may be asked beyond its time: integrators look two steps, of 5 ms at most, around them


@dataclass(frozen=True)
class Sines:
    """offset + sum of amplitude * sin(2 pi frequency t + phase)."""

    amplitude: ArrayLike = 0.0  # (k,)
    frequency: ArrayLike = 0.0  # (k,) Hz
    phase: ArrayLike = 0.0  # (k,) rad
    offset: float = 0.0

    def __call__(self, time: Array) -> tuple[Array, Array, Array]:
        """Return value and derivatives at `time`."""
        a, f, p = np.broadcast_arrays(
            *(np.atleast_1d(x).astype(float) for x in (self.amplitude, self.frequency, self.phase))
        )
        w = 2 * np.pi * f
        angle = np.multiply.outer(time, w) + p
        sine, cosine = np.sin(angle), np.cos(angle)
        return self.offset + sine @ a, cosine @ (a * w), -sine @ (a * w**2)


def constant(value: float) -> Sines:
    """Return the signal that stays at `value`."""
    return Sines(offset=value)


STILL = constant(0.0)


_BASIS = PPoly.from_spline(BSpline.basis_element(np.arange(7.0))).c[:, 10:4:-1]
"""Polynomials (6 powers, falling; 6 coefficients) of the knot interval that six neighbouring coefficients share."""


def check_within(time: Array, start: float, end: float) -> None:
    """Raise `InputError` unless all times (n,) lie within `start` to `end` s, give or take `AROUND`."""
    if not time.size:
        return
    first, last = float(time.min()), float(time.max())
    if last > end + AROUND:
        raise InputError(f"motion: expected at most {end:.6g} s, got {last:.6g} s")
    if first < start - AROUND:
        raise InputError(f"motion: expected times from {start:.6g} s on, got {first:.6g} s")


class Spline:
    """A spline of degree 5 through random or given coefficients: four times differentiable.

    It is defined from its first to its last knot, and raises `InputError` elsewhere.
    """

    def __init__(self, coefficients: ArrayLike, knot_spacing: float, start: float = 0.0) -> None:
        c = np.asarray(coefficients, dtype=float)
        knots = start + knot_spacing * np.arange(c.size - 4)
        powers = knot_spacing ** -np.arange(5.0, -1.0, -1.0)[:, None]
        pieces = powers * (_BASIS @ np.lib.stride_tricks.sliding_window_view(c, 6).T)
        self._pieces = with_derivatives(PPoly(pieces, knots))
        self.start, self.end = float(knots[0]), float(knots[-1])  # s

    def __call__(self, time: Array) -> tuple[Array, Array, Array]:
        """Return value and derivatives at `time`; `InputError` beyond the knots."""
        check_within(time, self.start, self.end)
        value, first, second = self._pieces(time).T
        return value, first, second


def with_derivatives(pieces: PPoly) -> PPoly:
    """Return polynomials (n,) -> (n, 3) of value, first and second derivative: one search for the piece, not three."""
    c = np.zeros((*pieces.c.shape, 3))
    c[..., 0] = pieces.c
    powers = np.arange(len(c) - 1.0, 0.0, -1.0)[:, None]
    for order in (1, 2):
        c[1:, :, order] = powers * c[:-1, :, order - 1]
    return PPoly(c, pieces.x)


KNOTS = 0.39  # of a period of a hand's bandwidth, over which a single random kernel reaches a sixth of its length
FINER = 4  # knots of the spline for each of the kernel's: between its knots a hand moves like at them


def hand(rng: np.random.Generator, duration: float, std: float, bandwidth: float, offset: float = 0.0) -> Spline:
    """Return a random signal like a hand's: smooth, band-limited, never a pure sine.

    White noise passes through the quintic B-spline with knots h = 0.39 / bandwidth apart, whose spectrum is
    sinc^6(f h): the power has fallen by 14 dB at `bandwidth` Hz and by over 70 dB at twice that. The noise comes four
    times as often as the knots; once a knot, its power would rise and fall from knot to knot, and what is square in the
    motion (a centripetal acceleration) would hum at 1 / h. The signal has the given standard deviation around `offset`;
    it is defined from 0 to `duration` s, and up to two knots longer.
    """
    spacing = KNOTS / bandwidth / FINER
    count = int(np.ceil(duration / spacing)) + 6
    white = rng.normal(scale=std, size=count + _KERNEL.size - 1)
    return Spline(offset + np.convolve(white, _KERNEL, mode="valid"), spacing)


def _kernel() -> Array:
    """Return the quintic B-spline at the finer knots, such that a spline through white noise has unit variance."""
    values = BSpline.basis_element(np.arange(7.0))(np.arange(1, 6 * FINER) / FINER)
    around = np.concatenate([np.zeros(6), values, np.zeros(6)])
    each = Spline(around, 1.0)(np.arange(0.0, around.size - 5, 1e-3))[0]  # what one sample of the noise adds
    return np.asarray(values / np.sqrt(np.sum(each**2) * 1e-3))


_KERNEL = _kernel()
