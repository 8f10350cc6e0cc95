"""Smooth functions of time with exact first and second derivatives."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, PPoly

from imubench.arrays import Array

Signal = Callable[[Array], tuple[Array, Array, Array]]
"""Takes times (n,) in s; returns value, first and second derivative, each (n,)."""


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


class Spline:
    """A spline of degree 5 through random or given coefficients: four times differentiable."""

    def __init__(self, coefficients: ArrayLike, knot_spacing: float, start: float = 0.0) -> None:
        c = np.asarray(coefficients, dtype=float)
        knots = start + knot_spacing * np.arange(c.size - 4)
        powers = knot_spacing ** -np.arange(5.0, -1.0, -1.0)[:, None]
        pieces = powers * (_BASIS @ np.lib.stride_tricks.sliding_window_view(c, 6).T)
        self._pieces = with_derivatives(PPoly(pieces, knots))

    def __call__(self, time: Array) -> tuple[Array, Array, Array]:
        """Return value and derivatives at `time`."""
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


def hand(rng: np.random.Generator, duration: float, std: float, bandwidth: float, offset: float = 0.0) -> Spline:
    """Return a random signal like a hand's: smooth, band-limited, never a pure sine.

    White coefficients pass through the quintic B-spline, whose spectrum is sinc^6(f h) for knots
    h apart: with h = 0.4 / bandwidth the power has fallen by 14 dB at `bandwidth` Hz and by 76 dB at
    twice that. The signal has the given standard deviation around `offset`; it is defined from 0
    to `duration` s.
    """
    spacing = 0.4 / bandwidth
    count = int(np.ceil(duration / spacing)) + 6
    norm = np.sqrt(_KERNEL_POWER)  # std of the spline of unit white coefficients, averaged over a knot
    return Spline(offset + rng.normal(scale=std / norm, size=count), spacing)


def _kernel_power() -> float:
    kernel = BSpline.basis_element(np.arange(7.0), extrapolate=False)
    x = (np.arange(6000) + 0.5) / 1000
    return float(np.sum(kernel(x) ** 2) / 1000)


_KERNEL_POWER = _kernel_power()
