"""r of a sensor that hangs on a spring and damper, along and about: what it moves by is what it feels.

In the axes B of the limb, which are the sensor's at rest, r_B = r0 + d. The force of the mount is all that the sensor
feels, f = m^2 d + 2 z m d' with m = 2 pi f0, so

    d'' + 2 z m d' + m^2 d = up - W' x r_B - W x (W x r_B) - 2 W x d'

with W the limb's rate and `up` gravity as an accelerometer at rest reads it. Turning is the same about the sensing
point: theta = -(k w' - l w''), k the softness in s^2, l that times the damper's lag, w the sensor's own rate. Then
W = w - theta' + theta x w, up_B = up + theta x up, and r = r_B - theta x r_B in the sensor's axes: first order in
theta, some mrad. What a spring adds to a rigid mount are f0, one for each axis of the sensor, z, k and l: five or six
numbers, and no function of time. That the three f0 are alike is probable before any sample, not certain.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from imubench.arrays import Array
from imubench.estimators.sliding_lines import R_STD
from imubench.estimators.sliding_rows import Rows
from imubench.estimators.sliding_spring_model import COUNT, DAMP, LAG, RATE, SOFT, START, TILT, TURN, Moved, SpringModel

MEAN = np.zeros(COUNT)
MEAN[TURN], MEAN[DAMP] = np.log(2 * np.pi * 5), np.log(0.2)
STD = np.concatenate(
    [np.full(3, R_STD), [1.0, 0.3, 0.3, 1.0, 5e-4, 1e-5], np.full(3, 0.01), np.full(3, 0.1), np.ones(6)]
)
"""Before any sample: r0 in m; log m, together and apart; log z; k in s^2; l in s^3; d and d' at the start less the
resting value in m and m/s; what is wrong with gravity, in units of the std that `Rows` has for it."""
MIX = np.eye(COUNT)
MIX[TURN, TURN] = [[1, 2**-0.5, 6**-0.5], [1, -(2**-0.5), 6**-0.5], [1, 0, -2 * 6**-0.5]]
SPREAD = MIX * STD
"""Parameters are MEAN + SPREAD x with x of unit prior."""


BOUND = np.full(COUNT, np.inf)
BOUND[TURN.start], BOUND[DAMP] = 2.5, 2.5  # a factor of 12 either way
BENT = np.arange(TURN.start, LAG + 1)  # numbers that do not act linearly
STRAIGHT = np.setdiff1d(np.arange(COUNT), BENT)
FARTHEST = 1.0  # standard deviations before any sample, of a step of a number that does not act linearly
STEPS = 25  # at most
ENOUGH = 1e-5  # nat, for a step to be worth equations anew: where numbers bend, much may be left after a small one
NEAR = 0.5  # nat, likewise for a window that follows on another
PROMISE = 5.0  # times what the next step promises; a rival that would need more is given up


@dataclass(frozen=True)
class Spring:
    """A fitted r(t) at the samples."""

    evidence: float  # nat
    noise: float  # residual power over that of the declared noise
    parameters: Array  # (21,), as MEAN has them
    covariance: Array  # (21, 21)
    moved: Moved = field(repr=False)  # at parameters less `step`
    step: Array  # (21,), the last one, of which what `moved` says is taken on as if straight
    rows: Rows = field(repr=False)
    name: str = "spring"

    @property
    def frequency(self) -> tuple[float, ...]:
        """f0 in Hz along each axis of the sensor."""
        return tuple((np.exp(self.parameters[TURN]) / (2 * np.pi)).tolist())

    @property
    def damping(self) -> float:
        """The damping ratio z."""
        return float(np.exp(self.parameters[DAMP]))

    def z(self, sample: int) -> Array:
        """Return d and d' (6,) in m and m/s at one sample."""
        return np.asarray(self.moved.z[sample] + self.moved.z_by[sample] @ self.step)

    @cached_property
    def values(self) -> Array:
        """r (n, 3) in m."""
        return np.asarray(self.moved.r + self.moved.r_by() @ self.step)

    @cached_property
    def covariances(self) -> Array:
        """The covariances of r (n, 3, 3) in m^2."""
        by = self.moved.r_by()
        return np.asarray(by @ self.covariance @ np.swapaxes(by, 1, 2))

    @cached_property
    def last_covariance(self) -> Array:
        """The covariance of r at the last sample, (3, 3) in m^2."""
        by = self.moved.r_by(slice(-1, None))[0]
        return np.asarray(by @ self.covariance @ by.T)


class Carried:
    """A fitted spring after its last sample: d is what the specific force f makes of it, m^2 d + 2 z m d' = f."""

    def __init__(self, spring: Spring):
        p = spring.parameters
        self._r0, self._softness, self._turn, self._damping = p[:3], float(p[SOFT]), np.exp(p[TURN]), spring.damping
        self._d, self._dt = spring.z(-1)[:3], -1.0

    def step(self, force: Array, dt: float) -> None:
        """Take d one step of `dt` s on under f (3,) in m/s^2."""
        if dt != self._dt:
            self._stay = np.exp(-dt * self._turn / (2 * self._damping))
            self._drive = (1 - self._stay) / self._turn**2
            self._dt = dt
        self._d = self._stay * self._d + self._drive * force

    def r(self, rate_change: Array) -> Array:
        """Return r (3,) in m, with theta = -k w' by the change w' (3,) of the rates in rad/s^2."""
        x, y, z = (self._r0 + self._d).tolist()
        a, b, c = (-self._softness * rate_change).tolist()
        return np.array([x - (b * z - c * y), y - (c * x - a * z), z - (a * y - b * x)])


@dataclass(frozen=True)
class _Trial:
    """Numbers x of unit prior, and what the samples say of them."""

    x: Array  # (21,)
    moved: Moved
    cost: float  # squares of whitened residuals and of x
    slope: Array  # (21,), half the derivative of the cost
    curvature: Array  # (21, 21), J^T J + I

    def step(self, scale: float) -> tuple[Array, float, float]:
        """Return Gauss and Newton's step, `scale` of it where numbers bend, and by how much it should lower the cost.

        The numbers that act linearly then go where they are best beside the others. Last comes the part of the cost
        that the ones that bend lower.
        """
        slope, curvature = self.slope, self.curvature
        stuck = (np.abs(self.x) >= BOUND) & (slope * self.x < 0)
        bent = BENT[~stuck[BENT]]
        inverse = np.linalg.inv(curvature[np.ix_(STRAIGHT, STRAIGHT)])
        across = curvature[np.ix_(bent, STRAIGHT)] @ inverse
        left = curvature[np.ix_(bent, bent)] - across @ curvature[np.ix_(STRAIGHT, bent)]
        far = -np.linalg.solve(left, slope[bent] - across @ slope[STRAIGHT])
        far *= scale * min(1.0, FARTHEST / max(float(np.abs(far).max(initial=0.0)), 1e-12))
        step = np.zeros(COUNT)
        step[bent] = np.clip(self.x[bent] + far, -BOUND[bent], BOUND[bent]) - self.x[bent]
        step[STRAIGHT] = -inverse @ (slope[STRAIGHT] + curvature[np.ix_(STRAIGHT, bent)] @ step[bent])
        return step, float(-2 * slope @ step - step @ curvature @ step), float(step[bent] @ left @ step[bent])


class _Descent:
    """From some numbers down to those that explain the samples best."""

    def __init__(self, rows: Rows):
        self.rows, self.model = rows, SpringModel(rows)
        self.y, self.tilted = rows.measured, rows.gravity[1] * rows.tilted

    def tried(self, x: Array) -> _Trial:
        """Return what the samples say of numbers x (21,)."""
        p = MEAN + SPREAD @ x
        moved = self.model.moved(p)
        off = moved.predicted + self.tilted @ p[TILT] - self.y
        J = moved.by.copy()
        J[:, TILT] += self.tilted
        J = J @ SPREAD
        return _Trial(x, moved, float(off @ off + x @ x), J.T @ off + x, J.T @ J + np.eye(COUNT))

    def judged(self, trial: _Trial) -> tuple[float, float, Array]:
        """Return evidence in nat, power of the noise, and information (21, 21) about x.

        The evidence is Laplace's: that of the Gaussian with the slope and the prior of the best one.
        """
        power = max(trial.cost / self.y.size, 1e-9)
        information = (trial.curvature - np.eye(COUNT)) / power + np.eye(COUNT)
        evidence = -0.5 * (self.y.size * (np.log(power) + 1) + np.linalg.slogdet(information)[1])
        return float(evidence), power, information

    def best(self, x: Array, rival: float, enough: float) -> tuple[_Trial, Array]:
        """Go down from x (21,), and return where that ended with the last step (21,), not worth equations anew.

        Given up where nothing promises the evidence of a rival, in nat.
        """
        now, scale = self.tried(x), 1.0
        for _ in range(STEPS):
            step, less, by_bent = now.step(scale)
            least = max(now.cost - less, 1e-3 * now.cost)
            if self.y.size * by_bent < 2 * enough * least:
                return now, step
            promised = 0.5 * self.y.size * np.log(now.cost / least)
            if self.judged(now)[0] + PROMISE * promised < rival:
                break
            tried = self.tried(now.x + step)
            if tried.cost < now.cost:
                now, scale = tried, min(1.0, 4 * scale)
            else:
                scale /= 4
        return now, np.zeros(COUNT)


def start(rows: Rows) -> Array:
    """Return numbers (21,) to start from when nothing is known: springs of 5 Hz at the r that fits best without."""
    first = MEAN.copy()
    first[:3] = rows.rigid
    return first


def fit(rows: Rows, rival: float = -np.inf) -> Spring:
    """Return the spring that explains the samples best, from `start` on.

    `rival` in nat: an evidence that has to be reached; what cannot is left where that was seen.
    """
    return _fitted(_Descent(rows), start(rows), rival, ENOUGH)


def followed(rows: Rows, last: Spring, dropped: int, rival: float = -np.inf) -> Spring:
    """Return the spring of a later window, from the last one's numbers; its first sample was number `dropped` there.

    `rival` as for `fit`.
    """
    descent, p, sample = _Descent(rows), last.parameters.copy(), min(dropped, last.rows.time.size - 1)
    p[TILT] = _tilt(rows, last, sample)
    z = last.z(sample)
    p[START], p[RATE] = z[:3] - descent.model.rest(p), z[3:]
    return _fitted(descent, p, rival, NEAR)


def _tilt(rows: Rows, last: Spring, sample: int) -> Array:
    """Return what is wrong with a later window's gravity (6,), for it to be what it was: the axes are others.

    Gravity is g + s (c + u d) in the axes of the first sample, s its std and u from -1 at the first sample to 1.
    """
    (g, std), (g_now, std_now) = last.rows.gravity, rows.gravity
    c, d = last.parameters[TILT].reshape(2, 3) * std
    before, now = last.rows.time, rows.time
    begin, end = (2 * float((t - before[0]) / (before[-1] - before[0])) - 1 for t in now[[0, -1]])  # u in the last one
    middle, half = (begin + end) / 2, (end - begin) / 2
    back = last.rows.turn[sample].T
    return np.concatenate([back @ (g + c + middle * d) - g_now, half * (back @ d)]) / std_now


def _fitted(descent: _Descent, p: Array, rival: float, enough: float) -> Spring:
    """Return the best spring from numbers p (21,); `enough` in nat may be left to a last step, taken as if straight."""
    x = np.clip(np.linalg.solve(SPREAD, p - MEAN), -0.99 * BOUND, 0.99 * BOUND)
    found, step = descent.best(x, rival, enough)
    less = max(float(-2 * found.slope @ step - step @ found.curvature @ step), 0.0)
    evidence, power, information = descent.judged(replace(found, cost=found.cost - less))
    covariance = SPREAD @ np.linalg.inv(information) @ SPREAD.T
    step = SPREAD @ step
    return Spring(evidence, power, MEAN + SPREAD @ found.x + step, covariance, found.moved, step, descent.rows)
