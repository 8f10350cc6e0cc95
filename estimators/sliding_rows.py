"""What the samples of one IMU say about an r that moves, without ever differentiating the gyroscope.

r(t) points from the sensor to a joint centre at rest, in sensor axes; w is the sensor's own angular rate, a its
acceleration, gravity taken out. The centre is at p + R r, and its acceleration is zero:

    felt:    a = -(r'' + 2 w x r' + w' x r + w x (w x r)) = -(v' + w x v),    v = r' + w x r
    unfelt:  a = -(w' x r + w x (w x r)) = -((w x r)' - w x r' + w x (w x r))

`unfelt` is how Garcia de Villa et al. have it: r varies, and the accelerometer does not feel that. Both are linear in r
and hold whatever makes r vary; a sensor that also turns on its limb has its own turning in w.

Each is multiplied by cubic B-splines b and summed up, derivatives moved onto b: sum b x' = -sum b' x. So w' is never
formed. A spline is two samples wide or more between knots, so that its spectrum is zero where a sum differs from an
integral. w is the gyroscope's record smoothed by splines of degree 7, as dense as its evidence asks for. Rows are
whitened by the noise of the accelerometer and by what smoothing leaves of the gyroscope's.

Gravity: an orientation filter's `up` wanders, and what is left of gravity in a would pass for sliding. So w is summed
up to a turn R0(t) from the first sample on, in which gravity rests; `up` gives its mean there, and its scatter there is
the std of what may be wrong with it, a constant and a drift, which are fitted along. An exact `up` hardly scatters.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from imubench import rotations
from imubench.arrays import Array
from imubench.errors import InputError
from imubench.estimators.mrvs import Sums, central_difference, lever_matrix
from imubench.estimators.sliding_splines import (
    SPACINGS,
    Smoothed,
    inverse_root,
    noise_of_sums,
    rounded,
    smoothed,
    splines,
    stencil,
)

AFTER, BEFORE = [1, 2, 0], [2, 0, 1]  # axes, of a cross product
LEAST_TILT = 0.002  # m/s^2, at least
LEAST = 40  # samples
LEAST_ROWS = 7  # splines, of three equations each: what 40 samples give at 100 Hz


def cross(w: Array, x: Array) -> Array:
    """Return w x x for w (n, 3) and many x (n, 3, columns) at once."""
    a, b, c = (w[:, i, None] for i in range(3))
    x0, x1, x2 = x[:, 0], x[:, 1], x[:, 2]
    return np.stack([b * x2 - c * x1, c * x0 - a * x2, a * x1 - b * x0], axis=1)


def skew(x: Array) -> Array:
    """Return [x]x (n, 3, 3) of x (n, 3)."""
    made = np.zeros((len(x), 3, 3))
    for i in range(3):
        made[:, BEFORE[i], AFTER[i]], made[:, AFTER[i], BEFORE[i]] = x[:, i], -x[:, i]
    return made


def crossed(a: Array, b: Array) -> Array:
    """Return a x b of vectors (..., 3)."""
    return a[..., AFTER] * b[..., BEFORE] - a[..., BEFORE] * b[..., AFTER]


def running(turns: Array) -> Array:
    """Return I, T_0, T_0 T_1, ... (n + 1, 3, 3) of turns T (n, 3, 3).

    Blocks of about sqrt n are multiplied side by side, then each with all before it.
    """
    n = len(turns)
    size = int(np.ceil(np.sqrt(n)))
    blocks = np.broadcast_to(np.eye(3), (size * size, 3, 3)).copy()
    blocks[:n] = turns
    blocks = blocks.reshape(size, size, 3, 3)
    for i in range(1, size):
        blocks[:, i] = blocks[:, i - 1] @ blocks[:, i]
    before = [np.eye(3)]
    for block in blocks[:-1, -1]:
        before.append(before[-1] @ block)
    products = (np.stack(before)[:, None] @ blocks).reshape(-1, 3, 3)[:n]
    return np.concatenate([np.eye(3)[None], products])


@dataclass(frozen=True)
class Rows:
    """Whitened equations of even samples; `predicted` turns any r(t) into what their left side should be."""

    time: Array  # (n,) s
    gyro: Array  # (n, 3) rad/s
    accel: Array  # (n, 3) m/s^2, specific force
    up: Array  # (n, 3) m/s^2, gravity as an accelerometer at rest reads it, sensor axes; by an orientation filter
    gyro_noise_std: float  # rad/s per sample
    accel_noise_std: float  # m/s^2 per sample
    densities: range = range(len(SPACINGS))  # of the smoothed rates, from which the best is taken
    step: float = field(init=False)  # s

    def __post_init__(self) -> None:
        if self.time.size < LEAST:
            raise InputError(f"sliding: expected {LEAST} samples or more, got {self.time.size}")
        steps = np.diff(self.time)
        mean = float(self.time[-1] - self.time[0]) / steps.size
        if not steps.min() > 0.9 * mean or not steps.max() < 1.1 * mean:
            step = float(np.median(steps))
            if not steps.min() > 0.5 * step or not steps.max() < 1.5 * step:
                row = int(np.argmax(np.abs(steps - step))) + 1
                raise InputError(
                    f"sliding: expected samples {step:g} s apart, got {steps[row - 1]:g} s before row {row}"
                )
        object.__setattr__(self, "step", rounded(mean))
        m, value, _ = stencil(self.step)
        if (self.time.size - value.size) // m + 1 < LEAST_ROWS:
            least, got = (value.size + (LEAST_ROWS - 1) * m) * self.step, self.time.size * self.step
            raise InputError(f"sliding: expected {least:g} s or more, got {got:g} s")

    @cached_property
    def operators(self) -> tuple[Any, Any]:
        """The splines and minus their slopes (rows, n)."""
        return splines(self.time.size, self.step)

    @cached_property
    def smoothed(self) -> Smoothed:
        """The smoothed rates."""
        return smoothed(self.time, self.gyro, self.densities)

    @property
    def motion(self) -> BSpline:
        """The smoothed w in rad/s of the time since the first sample; its derivatives are those of a spline."""
        return self.smoothed.spline

    @cached_property
    def since(self) -> Array:
        """Time (n,) in s since the first sample."""
        return self.time - self.time[0]

    @cached_property
    def rate(self) -> Array:
        """The smoothed w (n, 3) in rad/s."""
        return np.asarray(self.smoothed.basis.design @ self.motion.c)

    @cached_property
    def turn(self) -> Array:
        """R0 (n, 3, 3), from the sensor at each sample to the sensor at the first."""
        summed, w = self.motion.antiderivative()(self.since), self.rate
        steps = np.diff(summed, axis=0) + self.step**2 / 12 * crossed(w[:-1], w[1:])
        return running(rotations.to_matrix(rotations.exp(steps)))

    @cached_property
    def gravity(self) -> tuple[Array, float]:
        """Gravity (3,) in the axes of the first sample, and the std in m/s^2 of what is wrong with it."""
        at_first = np.einsum("nij,nj->ni", self.turn, self.up)
        mean = at_first.mean(axis=0)
        return mean, float(np.sqrt(np.mean((at_first - mean) ** 2))) + LEAST_TILT

    @cached_property
    def steady(self) -> Array:
        """Gravity (n, 3) in m/s^2 in sensor axes, at rest in the axes of the first sample."""
        return np.asarray(np.einsum("nji,j->ni", self.turn, self.gravity[0]))

    @cached_property
    def acceleration(self) -> Array:
        """The acceleration (n, 3) in m/s^2, `steady` taken out."""
        return self.accel - self.steady

    @cached_property
    def tilts(self) -> Array:
        """What may be wrong with `steady`: an error (n, 3, 6) of 1 m/s^2 along each axis, constant, then drifting."""
        back = np.swapaxes(self.turn, 1, 2)
        drift = np.linspace(-1.0, 1.0, self.time.size)
        return np.concatenate([back, drift[:, None, None] * back], axis=2)

    @cached_property
    def tilted(self) -> Array:
        """What `tilts` make of the left side: (rows * 3, 6)."""
        b = self.operators[0]
        return self.white((b @ self.tilts.reshape(self.time.size, -1)).reshape(b.shape[0], 3, 6))

    @cached_property
    def held(self) -> Array:
        """What 1 m of a constant r along each axis makes of the left side: (rows * 3, 3), felt or not."""
        w = skew(self.rate)
        return self.summed(-w, w @ w)

    @cached_property
    def rigid(self) -> Array:
        """The best constant r (3,) in m, zero where there is none: it sizes the noise, and starts the fits."""
        w, a = self.gyro[1:-1], self.acceleration[1:-1].ravel()
        M = lever_matrix(w, central_difference(self.gyro, self.time)).reshape(-1, 3)
        return np.nan_to_num(Sums(M.T @ M, M.T @ a, np.asarray(a @ a), len(w)).solve()[0])

    @cached_property
    def whitener(self) -> Array:
        """What makes the noise white, (rows, rows): the inverse of its covariance's root, alike for x, y and z.

        Gyroscope noise n enters as (n x r)', two thirds of |r|^2 for each axis; smoothing keeps its projection.
        """
        lever = 2 / 3 * float(self.rigid @ self.rigid) * self.gyro_noise_std**2
        alone = noise_of_sums(self.time.size, self.step)
        return inverse_root(self.accel_noise_std**2 * alone + lever * self.smoothed.basis.kept)

    @cached_property
    def measured(self) -> Array:
        """The left side (rows * 3,), whitened: of size 1 if there were but noise."""
        return self.white((self.operators[0] @ self.acceleration)[..., None])[:, 0]

    def predicted(self, r: Array, rate: Array, felt: bool = True) -> Array:
        """Return what many r and r' (n, 3, columns), in m and m/s, make of the left side: (rows * 3, columns)."""
        w = self.rate
        turned = cross(w, r)
        if felt:
            v = rate + turned
            parts = -v, cross(w, v)
        else:
            parts = -turned, cross(w, turned - rate)
        return self.summed(*parts)

    def summed(self, along: Array, other: Array) -> Array:
        """Return whitened (rows * 3, columns): `along` summed up with -b', `other` with -b, both (n, 3, columns)."""
        b, minus = self.operators
        n, _, columns = along.shape
        through = minus @ along.reshape(n, -1) - b @ other.reshape(n, -1)
        return self.white(through.reshape(b.shape[0], 3, columns))

    def white(self, x: Array) -> Array:
        """Return x (rows, 3, columns) whitened, as (rows * 3, columns)."""
        rows = x.shape[0]
        return (self.whitener @ x.reshape(rows, -1)).reshape(rows * 3, -1)
