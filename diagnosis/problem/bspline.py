"""Splines over time on one set of evenly spaced knots, quintic, so that accelerations are smooth too."""

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, PPoly
from scipy.sparse import csr_array

from imubench.arrays import Array
from imubench.jets import Jet, variable

DEGREE = 5
SUPPORT = DEGREE + 1  # coefficients that a point depends on
KEPT_BASES = 32  # times and orders whose weights are kept: a fit asks for the same ones at every step;
LONG_TIMES, KEPT_LONG_BASES = 12_000, 4  # times of which only those of one moment are: memory
Held = NDArray[np.float32] | Array
"""Signals as a term holds them: in single precision, for twenty of them in a long recording are half a gigabyte."""


@cache
def polynomials() -> Array:
    """Return the pieces (6, 6) of the quintic B-spline: [power, coefficient] on one interval of length 1."""
    basis = PPoly.from_spline(BSpline.basis_element(np.arange(SUPPORT + 1.0), extrapolate=False))
    start = int(np.searchsorted(basis.x, 0.0, side="right")) - 1
    pieces = np.stack([basis.c[:, start + i] for i in range(SUPPORT)], axis=1)  # [falling power, interval]
    return pieces[::-1, ::-1].copy()  # coefficient i is in its interval SUPPORT - 1 - i


@dataclass(frozen=True)
class Knots:
    """Evenly spaced knots: `count` coefficients from `start` s, `step` s apart."""

    start: float
    step: float
    count: int

    @classmethod
    def over(cls, start: float, end: float, step: float) -> "Knots":
        """Return knots that cover start..end, so laid that no sample at a multiple of the step meets one."""
        intervals = int(np.ceil((end - start) / step + 1.0))
        return cls(start - step / 2, step, intervals + DEGREE)

    def weights(self, time: Array, order: int) -> tuple[NDArray[np.int64], Array]:
        """Return the first coefficient (n,) and the weights (n, 6) of the `order`-th derivative at times (n,).

        Both are kept and not to be written to.
        """
        known = self._at(time, order)
        return known.first, known.weights

    @property
    def rounding(self) -> float:
        """By how much of an interval places within it may differ that are the same but for rounding.

        A step that is read off the stamps is off by their rounding, and places by that times all intervals.
        """
        return 2 * self.count * float(np.spacing(float(self.count)))

    def phase(self, time: Array) -> float | None:
        """Return where in their intervals, of length 1, all times (n,) lie alike; None where they do not."""
        return self._at(time, 0).phase

    def weights_at(self, phase: float, order: int) -> Array:
        """Return the weights (6,) of the `order`-th derivative at a place in an interval, of length 1."""
        return _weights(np.array([phase]), order, self.step)[0]

    def values(self, time: Array, order: int, coefficients: Array) -> Array:
        """Return the `order`-th derivative (n, w) at times (n,) of splines with coefficients (count, w)."""
        return np.asfortranarray(self._at(time, order).matrix @ coefficients)

    def _at(self, time: Array, order: int) -> "Weights":
        return (_weighed if len(time) < LONG_TIMES else _weighed_long)(self, time.tobytes(), order)


@dataclass(frozen=True)
class Weights:
    """What splines at some times depend on, and how far."""

    first: NDArray[np.int64]  # (n,) coefficient
    weights: Array  # (n, 6)
    matrix: csr_array  # (n, count) the same
    phase: float | None  # where in their intervals, of length 1, all times lie alike


def _weights(x: Array, order: int, step: float) -> Array:
    """Return the weights (n, 6) of the `order`-th derivative at places x (n,) in an interval of length 1."""
    table = polynomials()
    total = np.zeros((len(x), SUPPORT))
    for power in range(DEGREE, order - 1, -1):
        factor = float(np.prod(np.arange(power, power - order, -1))) if order else 1.0
        total = total * x[:, None] + factor * table[power]
    return np.asarray(total / step**order)


def _weigh(knots: Knots, stamps: bytes, order: int) -> Weights:
    place = (np.frombuffer(stamps) - knots.start) / knots.step
    first = np.clip(np.floor(place).astype(np.int64), 0, knots.count - SUPPORT)
    x = place - first
    weights = _weights(x, order, knots.step)
    alike = len(x) > 0 and float(np.ptp(x)) < knots.rounding
    columns = (first[:, None] + np.arange(SUPPORT)).ravel()
    ends = np.arange(0, columns.size + 1, SUPPORT)
    for kept in (first, weights):
        kept.setflags(write=False)
    matrix = csr_array((weights.ravel(), columns, ends), (len(place), knots.count))
    return Weights(first, weights, matrix, float(np.mean(x)) if alike else None)


_weighed, _weighed_long = lru_cache(KEPT_BASES)(_weigh), lru_cache(KEPT_LONG_BASES)(_weigh)


def place_of(widths: dict[str, int], name: str) -> slice:
    """Return where the numbers of a name lie, those of all names in a row; `KeyError` where there is no such name."""
    at = 0
    for known, width in widths.items():
        if known == name:
            return slice(at, at + width)
        at += width
    raise KeyError(name)


@dataclass(frozen=True)
class Tracks:
    """Splines of several widths that share their knots, and how they lie side by side."""

    knots: Knots
    widths: dict[str, int]

    @property
    def width(self) -> int:
        """Numbers per knot."""
        return sum(self.widths.values())

    def columns(self, name: str) -> slice:
        """Return where a spline lies among the numbers of a knot."""
        return place_of(self.widths, name)


@dataclass(frozen=True)
class Moment:
    """The splines at times that may themselves depend on a parameter (a clock's offset)."""

    tracks: Tracks
    coefficients: Array  # (count, width)
    time: Jet  # (n, 1) s

    def track(self, name: str, order: int = 0) -> Jet:
        """Return a spline's `order`-th derivative (n, width) and its blocks."""
        jet = variable((name, order), self._value(name, order))
        if not self.time.blocks:
            return jet
        slope = self._value(name, order + 1)[:, :, None]
        return Jet(jet.value, jet.blocks | {key: slope * d for key, d in self.time.blocks.items()})

    def _value(self, name: str, order: int) -> Array:
        chosen = self.coefficients[:, self.tracks.columns(name)]
        return self.tracks.knots.values(self.time.value[:, 0], order, chosen)


def interpolated(time: Array, known: Array, values: Held) -> Array:
    """Return values (n, m) at times (n,), straight between those at the known times, held beyond."""
    after = np.clip(np.searchsorted(known, time), 1, len(known) - 1)
    share = np.clip((time - known[after - 1]) / (known[after] - known[after - 1]), 0.0, 1.0)[:, None]
    return np.asarray(values[after - 1] * (1 - share) + values[after] * share)
