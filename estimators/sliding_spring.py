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

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm
from scipy.optimize import least_squares
from scipy.signal import lfilter

from imubench.arrays import Array
from imubench.estimators.sliding_lines import R_STD
from imubench.estimators.sliding_rows import Rows, cross

ROUNDS = 5  # of putting d back into its own inertial forces; each leaves a tenth of the error at 2 Hz, less above
TURN, DAMP, SOFT, LAG = slice(3, 6), 6, 7, 8
START, RATE, TILT = slice(9, 12), slice(12, 15), slice(15, 21)
COUNT = 21
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


def oscillator(u: Array, start: Array, turn: float, damping: float, step: float) -> tuple[Array, Array]:
    """Return x and x' (n, columns) of x'' + 2 z m x' + m^2 x = u, u (n, columns) straight between samples.

    `start` (2, columns) is x and x' at the first.
    """
    M = np.zeros((4, 4))
    M[0, 1], M[2, 3] = 1.0, 1 / step
    M[1, :3] = -(turn**2), -2 * damping * turn, 1.0
    E = expm(M * step)
    drive = E[:2, 2, None, None] * u[:-1] + E[:2, 3, None, None] * np.diff(u, axis=0)
    values, vectors = np.linalg.eig(E[:2, :2].astype(complex))
    modes = np.einsum("ij,jnc->inc", np.linalg.inv(vectors), np.concatenate([start[:, None], drive], axis=1))
    run = np.stack([lfilter([1.0], [1.0, -v], z, axis=0) for v, z in zip(values, modes, strict=True)])
    x, rate = np.einsum("ij,jnc->inc", vectors, run).real
    return x, rate


@dataclass(frozen=True)
class Spring:
    """A fitted r(t) at the samples."""

    evidence: float  # nat
    noise: float  # residual power over that of the declared noise
    parameters: Array  # (21,), as MEAN has them
    covariance: Array  # (21, 21)
    offset: Array  # (n, 3) m, d
    values: Array  # (n, 3) m, r
    covariances: Array  # (n, 3, 3) m^2
    name: str = "spring"

    @property
    def frequency(self) -> tuple[float, ...]:
        """f0 in Hz along each axis of the sensor."""
        return tuple((np.exp(self.parameters[TURN]) / (2 * np.pi)).tolist())

    @property
    def damping(self) -> float:
        """The damping ratio z."""
        return float(np.exp(self.parameters[DAMP]))


class SpringModel:
    """r(t) and what the samples say of it, for the numbers of `MEAN`; derivatives are those of the equations above."""

    def __init__(self, rows: Rows):
        self.rows = rows
        self.rates = [np.asarray(rows.motion(rows.time, k)) for k in range(1, 5)]

    def limb(self, p: Array) -> tuple[Array, ...]:
        """Return theta, theta' and the limb's W, W' and up, each (n, 3)."""
        w, (w1, w2, w3, w4) = self.rows.rate, self.rates
        theta, theta1, theta2 = (-(p[SOFT] * a - p[LAG] * b) for a, b in ((w1, w2), (w2, w3), (w3, w4)))
        W = w - theta1 + np.cross(theta, w)
        W1 = w1 - theta2 + np.cross(theta1, w) + np.cross(theta, w1)
        up = self.rows.steady + self.rows.tilts @ (self.rows.gravity[1] * p[TILT])
        return theta, theta1, W, W1, up + np.cross(theta, up)

    def _hang(self, p: Array, W: Array, W1: Array, force: Array, start: Array) -> tuple[Array, Array]:
        """Return d and d' (n, 3, columns) under forces (n, 3, columns) besides those that d itself makes."""
        turn, damping = np.exp(p[TURN]).tolist(), float(np.exp(p[DAMP]))
        d = rate = np.zeros_like(force)
        for _ in range(ROUNDS):
            u = force - cross(W1, d) - cross(W, cross(W, d)) - 2 * cross(W, rate)
            axes = [oscillator(u[:, i], start[:, i], m, damping, self.rows.step) for i, m in enumerate(turn)]
            d, rate = (np.stack([x[k] for x in axes], axis=1) for k in range(2))
        return d, rate

    def _hung(self, p: Array) -> tuple[Array, ...]:
        """Return theta, theta', W, W', d and d', each (n, 3)."""
        theta, theta1, W, W1, up = self.limb(p)
        force = up - np.cross(W1, p[:3]) - np.cross(W, np.cross(W, p[:3]))
        start = np.stack([p[START] + force[0] / np.exp(2 * p[TURN]), p[RATE]])
        d, rate = self._hang(p, W, W1, force[..., None], start[..., None])
        return theta, theta1, W, W1, d[..., 0], rate[..., 0]

    def moved(self, p: Array) -> tuple[Array, Array, Array]:
        """Return r, r' and d (n, 3)."""
        theta, theta1, _, _, d, rate = self._hung(p)
        r = p[:3] + d
        return r - np.cross(theta, r), rate - np.cross(theta, rate) - np.cross(theta1, r), d

    def jacobian(self, p: Array) -> tuple[Array, Array]:
        """Return dr/dp and dr'/dp (n, 3, 21).

        r0, the start and gravity act linearly; log m and log z as forces -2 m (m d + z d') and -2 m z d', all on the
        same oscillator. k and l, which act on everything a little, go by a difference.
        """
        theta, theta1, W, W1, d, rate = self._hung(p)
        n, turn, damping = len(W), np.exp(p[TURN]), float(np.exp(p[DAMP]))
        force, start = np.zeros((n, 3, COUNT)), np.zeros((2, 3, COUNT))
        eye = np.broadcast_to(np.eye(3), (n, 3, 3))
        tilts = self.rows.gravity[1] * self.rows.tilts
        force[..., :3] = -cross(W1, eye) - cross(W, cross(W, eye))
        force[..., TILT] = tilts + cross(theta, tilts)
        start[0] = force[0] / turn[:, None] ** 2
        force[..., TURN] = np.einsum("ni,ik->nik", -2 * turn * (turn * d + damping * rate), np.eye(3))
        start[0, :, TURN] = np.diag(-2 * (d[0] - p[START]))
        force[..., DAMP] = -2 * turn * damping * rate
        start[0, :, START] = start[1, :, RATE] = np.eye(3)
        by, rate_by = self._hang(p, W, W1, force, start)
        by[..., :3] += eye
        r_by, rate_by = by - cross(theta, by), rate_by - cross(theta, rate_by) - cross(theta1, by)
        for i in (SOFT, LAG):
            r_by[..., i], rate_by[..., i] = self._by_softness(p, i)
        return r_by, rate_by

    def _by_softness(self, p: Array, i: int) -> tuple[Array, Array]:
        h = np.zeros(COUNT)
        h[i] = 1e-2 * STD[i]
        (r2, rate2, _), (r1, rate1, _) = self.moved(p + h), self.moved(p - h)
        return (r2 - r1) / (2 * h[i]), (rate2 - rate1) / (2 * h[i])


def fit(rows: Rows, start: ArrayLike | None = None) -> Spring:
    """Return the spring that explains the samples best, from `start` (21,) or from springs of 5 Hz.

    Its evidence is Laplace's: that of the Gaussian with the slope and the prior of the best one.
    """
    model, y, tilted = SpringModel(rows), rows.measured, rows.gravity[1] * rows.tilted

    def residual(x: Array) -> Array:
        p = MEAN + SPREAD @ x
        r, rate, _ = model.moved(p)
        return np.concatenate([rows.predicted(r[..., None], rate[..., None])[:, 0] + tilted @ p[TILT] - y, x])

    def slope(x: Array) -> Array:
        J = rows.predicted(*model.jacobian(MEAN + SPREAD @ x))
        J[:, TILT] += tilted
        return np.concatenate([J @ SPREAD, np.eye(COUNT)])

    first = MEAN.copy() if start is None else np.asarray(start, dtype=float)
    if start is None:
        first[:3] = rows.rigid
    bound = np.full(COUNT, np.inf)
    bound[TURN.start], bound[DAMP] = 2.5, 2.5  # a factor of 12 either way
    x0 = np.clip(np.linalg.solve(SPREAD, first - MEAN), -0.99 * bound, 0.99 * bound)
    found = least_squares(residual, x0, slope, bounds=(-bound, bound), xtol=1e-6, ftol=1e-7, max_nfev=25)
    J = slope(found.x)[: y.size]
    power = max(float(found.fun @ found.fun) / y.size, 1e-9)
    information = J.T @ J / power + np.eye(COUNT)
    evidence = -0.5 * (y.size * (np.log(power) + 1) + np.linalg.slogdet(information)[1])
    p = MEAN + SPREAD @ found.x
    r, _, d = model.moved(p)
    by = model.jacobian(p)[0]
    covariance = SPREAD @ np.linalg.inv(information) @ SPREAD.T
    spread = np.einsum("nip,pq,njq->nij", by, covariance, by, optimize=True)
    return Spring(float(evidence), power, p, covariance, d, r, spread)
