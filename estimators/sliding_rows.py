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
from scipy import linalg, sparse
from scipy.interpolate import BSpline, make_lsq_spline

from imubench import rotations
from imubench.arrays import Array
from imubench.errors import InputError
from imubench.estimators.mrvs import solve_differenced

KNOTS = 0.04  # s between splines: passes half of the amplitude at 9 Hz
LEAST_TILT = 0.002  # m/s^2, at least
LEAST = 40  # samples, about as many as give a dozen splines of rows
SPACINGS = (0.5, 0.35, 0.25, 0.18, 0.125, 0.09, 0.0625, 0.045)  # s between knots of the smoothed rates
DEGREE = 7  # so that the fourth derivative is smooth too


def splines(count: int, step: float) -> tuple[Any, Any]:
    """Return b and -b' (rows, count) at even samples `step` s apart, as sparse matrices; b sums to 1."""
    m = max(2, round(KNOTS / step))
    u = (np.arange(1, 4 * m) - 2 * m) / m
    s = np.abs(u)
    value = np.where(s < 1, 2 / 3 - s**2 + s**3 / 2, (2 - s) ** 3 / 6) / m
    slope = np.sign(u) * np.where(s < 1, -2 * s + 1.5 * s**2, -((2 - s) ** 2) / 2) / (m * m * step)
    starts = np.arange(0, count - u.size + 1, m)
    rows, columns = np.repeat(np.arange(starts.size), u.size), (starts[:, None] + np.arange(u.size)).ravel()
    shape = (starts.size, count)
    b, minus = (sparse.csr_matrix((np.tile(x, starts.size), (rows, columns)), shape=shape) for x in (value, -slope))
    return b, minus


def smoothed(time: Array, gyro: Array) -> BSpline:
    """Return w(t) as a spline of degree 7, the density of its knots by Bayes' information criterion."""
    n, best, found = time.size, np.inf, None
    for spacing in SPACINGS:
        spans = max(2, round((time[-1] - time[0]) / spacing))
        if spans + DEGREE > n // 2:
            break
        inner = np.linspace(time[0], time[-1], spans + 1)
        knots = np.concatenate([np.full(DEGREE, time[0]), inner, np.full(DEGREE, time[-1])])
        spline = make_lsq_spline(time, gyro, knots, DEGREE)
        left = np.maximum(np.sum((gyro - spline(time)) ** 2, axis=0), 1e-12 * n).sum()
        criterion = 3 * n * np.log(left) + 3 * (spans + DEGREE) * np.log(3 * n)
        if criterion < best:
            best, found = criterion, spline
    assert found is not None
    return found


def cross(w: Array, x: Array) -> Array:
    """Return w x x for w (n, 3) and many x (n, 3, columns) at once."""
    a, b, c = (w[:, i, None] for i in range(3))
    x0, x1, x2 = x[:, 0], x[:, 1], x[:, 2]
    return np.stack([b * x2 - c * x1, c * x0 - a * x2, a * x1 - b * x0], axis=1)


@dataclass(frozen=True)
class Rows:
    """Whitened equations of even samples; `predicted` turns any r(t) into what their left side should be."""

    time: Array  # (n,) s
    gyro: Array  # (n, 3) rad/s
    accel: Array  # (n, 3) m/s^2, specific force
    up: Array  # (n, 3) m/s^2, gravity as an accelerometer at rest reads it, sensor axes; by an orientation filter
    gyro_noise_std: float  # rad/s per sample
    accel_noise_std: float  # m/s^2 per sample
    step: float = field(init=False)  # s

    def __post_init__(self) -> None:
        steps = np.diff(self.time)
        if self.time.size < LEAST:
            raise InputError(f"sliding: expected {LEAST} samples or more, got {self.time.size}")
        step = float(np.median(steps))
        if not steps.min() > 0.5 * step or not steps.max() < 1.5 * step:
            row = int(np.argmax(np.abs(steps - step))) + 1
            raise InputError(f"sliding: expected samples {step:g} s apart, got {steps[row - 1]:g} s before row {row}")
        object.__setattr__(self, "step", float(self.time[-1] - self.time[0]) / steps.size)

    @cached_property
    def operators(self) -> tuple[Any, Any]:
        """The splines and minus their slopes (rows, n)."""
        return splines(self.time.size, self.step)

    @cached_property
    def motion(self) -> BSpline:
        """The smoothed w(t) in rad/s; its derivatives are those of a spline."""
        return smoothed(self.time, self.gyro)

    @cached_property
    def rate(self) -> Array:
        """The smoothed w (n, 3) in rad/s."""
        return np.asarray(self.motion(self.time))

    @cached_property
    def turn(self) -> Array:
        """R0 (n, 3, 3), from the sensor at each sample to the sensor at the first."""
        summed, w = self.motion.antiderivative()(self.time), self.rate
        steps = np.diff(summed, axis=0) + self.step**2 / 12 * np.cross(w[:-1], w[1:])
        turns = [np.eye(3)]
        for step in rotations.to_matrix(rotations.exp(steps)):
            turns.append(turns[-1] @ step)
        return np.stack(turns)

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
        return self._white((b @ self.tilts.reshape(self.time.size, -1)).reshape(b.shape[0], 3, 6))

    @cached_property
    def rigid(self) -> Array:
        """The best constant r (3,) in m, zero where there is none: it sizes the noise, and starts the fits."""
        return np.nan_to_num(solve_differenced(self.gyro, self.acceleration, self.time)[0])

    @cached_property
    def _whitener(self) -> Array:
        """The lower root of the noise's covariance (rows, rows), alike for x, y and z.

        Gyroscope noise n enters as (n x r)', two thirds of |r|^2 for each axis; smoothing keeps its projection.
        """
        b, minus = self.operators
        lever = np.sqrt(2 / 3 * float(self.rigid @ self.rigid)) * self.gyro_noise_std
        Q = np.linalg.qr(BSpline.design_matrix(self.time, self.motion.t, DEGREE).toarray())[0]
        left = lever * (minus @ Q)
        covariance = self.accel_noise_std**2 * (b @ b.T).toarray() + left @ left.T
        return np.asarray(linalg.cholesky(covariance, lower=True))

    @cached_property
    def measured(self) -> Array:
        """The left side (rows * 3,), whitened: of size 1 if there were but noise."""
        return self._white((self.operators[0] @ self.acceleration)[..., None])[:, 0]

    def predicted(self, r: Array, rate: Array, felt: bool = True) -> Array:
        """Return what many r and r' (n, 3, columns), in m and m/s, make of the left side: (rows * 3, columns)."""
        w = self.rate
        turned = cross(w, r)
        if felt:
            v = rate + turned
            parts = -v, cross(w, v)
        else:
            parts = -turned, cross(w, turned - rate)
        b, minus = self.operators
        n, _, columns = r.shape
        through = minus @ parts[0].reshape(n, -1) - b @ parts[1].reshape(n, -1)
        return self._white(through.reshape(b.shape[0], 3, columns))

    def _white(self, x: Array) -> Array:
        """Return x (rows, 3, columns) whitened, as (rows * 3, columns)."""
        rows = x.shape[0]
        solved = linalg.solve_triangular(self._whitener, x.reshape(rows, -1), lower=True, check_finite=False)
        return np.asarray(solved.reshape(rows * 3, -1))
