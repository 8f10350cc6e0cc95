"""Splines over time on one set of evenly spaced knots, quintic, so that accelerations are smooth too."""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, PPoly

from imubench.arrays import Array
from imubench.jets import Jet, variable

DEGREE = 5
SUPPORT = DEGREE + 1  # coefficients that a point depends on


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
        """Return the first coefficient (n,) and the weights (n, 6) of the `order`-th derivative at times (n,)."""
        place = (time - self.start) / self.step
        first = np.clip(np.floor(place).astype(np.int64), 0, self.count - SUPPORT)
        x = place - first
        table = polynomials()
        total = np.zeros((len(time), SUPPORT))
        for power in range(DEGREE, order - 1, -1):
            factor = float(np.prod(np.arange(power, power - order, -1))) if order else 1.0
            total = total * x[:, None] + factor * table[power]
        return first, total / self.step**order


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
        at = 0
        for known, width in self.widths.items():
            if known == name:
                return slice(at, at + width)
            at += width
        raise KeyError(name)


@dataclass(frozen=True)
class Moment:
    """The splines at times that may themselves depend on a parameter (a clock's offset)."""

    tracks: Tracks
    coefficients: Array  # (count, width)
    time: Jet  # (n, 1) s
    known: dict[int, tuple[NDArray[np.int64], Array]] = field(default_factory=dict, compare=False, repr=False)

    def track(self, name: str, order: int = 0) -> Jet:
        """Return a spline's `order`-th derivative (n, width) and its blocks."""
        jet = variable((name, order), self._value(name, order))
        if not self.time.blocks:
            return jet
        slope = self._value(name, order + 1)[:, :, None]
        return Jet(jet.value, jet.blocks | {key: slope * d for key, d in self.time.blocks.items()})

    def _value(self, name: str, order: int) -> Array:
        if order not in self.known:
            self.known[order] = self.tracks.knots.weights(self.time.value[:, 0], order)
        first, weights = self.known[order]
        chosen = np.ascontiguousarray(self.coefficients[:, self.tracks.columns(name)].T)
        out = weights[:, 0] * chosen[:, first]
        for i in range(1, SUPPORT):
            out += weights[:, i] * chosen[:, first + i]
        return out.T  # samples next to each other in memory, as jets like them
