"""How a hand turns things: irregular strokes, rests that are exactly still, small bounded wander.

Every signal here has exact first and second derivatives, made by the product and the chain rule.
"""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.sim.signals import Signal, Sines, constant, hand

Values = tuple[Array, Array, Array]  # a signal's value, first and second derivative, each (n,)

HARMONIC = 0.2  # of the fundamental: a stroke is no sine
UNEVEN = 0.25  # std of a stroke's relative amplitude
SWAY = 0.9  # rad, std of the strokes' phase about an even beat
CALM = 0.4  # of the beat: the bandwidth of both


@dataclass(frozen=True)
class Sum:
    """The weighted sum of signals: `parts` holds (weight, signal)."""

    parts: tuple[tuple[float, Signal], ...]

    def __call__(self, time: Array) -> Values:
        """Return value and derivatives at `time`."""
        terms = [(weight, signal(time)) for weight, signal in self.parts]
        value, first, second = (np.sum([weight * term[k] for weight, term in terms], axis=0) for k in range(3))
        return value, first, second


@dataclass(frozen=True)
class Product:
    """The product of two signals."""

    left: Signal
    right: Signal

    def __call__(self, time: Array) -> Values:
        """Return value and derivatives at `time`, by the product rule."""
        (a, da, dda), (b, db, ddb) = self.left(time), self.right(time)
        return a * b, da * b + a * db, dda * b + 2 * da * db + a * ddb


@dataclass(frozen=True)
class Composed:
    """outer(inner(t)): with a clock as the inner signal, the outer one rests while the clock does."""

    outer: Signal
    inner: Signal

    def __call__(self, time: Array) -> Values:
        """Return value and derivatives at `time`, by the chain rule."""
        at, d, dd = self.inner(time)
        value, first, second = self.outer(at)
        return value, first * d, second * d**2 + first * dd


@dataclass(frozen=True)
class Step:
    """From 0 until `start` to 1 from `end` on (s), along 10 x^3 - 15 x^4 + 6 x^5: twice differentiable."""

    start: float
    end: float

    def __call__(self, time: Array) -> Values:
        """Return value and derivatives at `time`; outside the step the derivatives are exactly zero."""
        span = self.end - self.start
        x = np.clip((time - self.start) / span, 0.0, 1.0)
        slope, bend = 30 * (x * (1 - x)) ** 2, 60 * x * (1 - x) * (1 - 2 * x)
        return x**3 * (10 - 15 * x + 6 * x**2), slope / span, bend / span**2


@dataclass(frozen=True)
class Clock:
    """A clock that runs from `start` to `end` (s) and stands still elsewhere; it takes `ramp` s to start and to stop.

    Its rate is a `Step` up and one down, so it is three times differentiable.
    """

    start: float
    end: float
    ramp: float = 1.0

    def __call__(self, time: Array) -> Values:
        """Return the clock's reading (0 before `start`), its rate and the rate's derivative at `time`."""
        value = np.zeros_like(time)
        rate, change = np.zeros_like(time), np.zeros_like(time)
        for sign, start in ((1.0, self.start), (-1.0, self.end - self.ramp)):
            since = (time - start) / self.ramp
            x = np.clip(since, 0.0, 1.0)
            value += sign * self.ramp * (x**4 * (2.5 - 3 * x + x**2) + np.maximum(since - 1.0, 0.0))
            step, slope, _ = Step(start, start + self.ramp)(time)
            rate, change = rate + sign * step, change + sign * slope
        return value, rate, change


def _tanh(at: Array) -> Values:
    value = np.tanh(at)
    slope = 1 - value**2
    return value, slope, -2 * value * slope


def wander(
    rng: np.random.Generator, duration: float, limit: float, bandwidth: float, centre: float = 0.0
) -> Composed | Sum:
    """Return a slow random wander about `centre` that never leaves +- `limit`, with an rms of about half of it."""
    inside = Composed(_tanh, hand(rng, duration, 0.65, bandwidth))
    return Sum(((1.0, constant(centre)), (limit, inside)))


def strokes(rng: np.random.Generator, duration: float, rate: float, beat: float) -> Signal:
    """Return strokes to and fro, an angle in rad: `beat` Hz on the whole, `rate` rad/s rms over `duration` s.

    a(t) (sin p(t) + 0.2 sin(2 p(t) + const)), with amplitude and beat wandering slowly: neither two
    strokes nor the two ways of one are alike. Almost all power lies below 3 `beat`.
    """
    amplitude = hand(rng, duration, UNEVEN, CALM * beat, offset=1.0)
    start, lag = rng.uniform(0, 2 * np.pi, size=2)
    sway = hand(rng, duration, SWAY, CALM * beat)
    phase = Sum(((1.0, _ramp(2 * np.pi * beat, start)), (1.0, sway)))
    shape = Composed(Sines([1.0, HARMONIC], np.array([1.0, 2.0]) / (2 * np.pi), [0.0, lag]), phase)
    unscaled = Product(amplitude, shape)
    first = unscaled(np.arange(0.0, duration, 0.05 / beat))[1]
    return Sum(((rate / float(np.sqrt(np.mean(first**2))), unscaled),))


def _ramp(slope: float, start: float) -> Signal:
    return lambda time: (start + slope * time, np.full_like(time, slope), np.zeros_like(time))
