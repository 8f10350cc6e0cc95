"""The extended Kalman filter that ArVE and ArVE_d share: Garcia de Villa et al., section III-A.

State, in sensor axes: r, w, w' and, for ArVE_d, r' last, so that a measurement sees the first nine in both.
Prediction: r by r' (ArVE: r stays), w by w', which drifts as a random walk does; so does r' (ArVE: r).
Measurement: z = (w_I, a), h = (w, -(w' x r) - w x (w x r)), eq. (4). docs/joint-centre.md has frames and signs.
"""

import math
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lapack

from imubench.arrays import Array, frozen
from imubench.errors import InputError, unknown
from imubench.estimators import mrvs
from imubench.estimators.gravity import How
from imubench.inputs.toml import load_toml
from imubench.recording import positive

INITIAL = 60  # samples that give r0 (section IV-C)


@dataclass(frozen=True)
class Covariances:
    """What P0, Q and R are made of; densities are those of white noise that drives a random walk."""

    r_std: float  # m, of r0
    angular_acceleration_std: float  # rad/s^2, of w'0 = 0
    angular_acceleration_density: float  # rad/s^2/sqrt(s), the drift of w'
    gyro_noise_std: float  # rad/s per sample
    acceleration_noise_std: float  # m/s^2 per sample
    r_density: float = 0.0  # m/sqrt(s), the drift of r
    r_rate_std: float = 0.0  # m/s, of r'0 = 0; ArVE_d only
    r_rate_density: float = 0.0  # m/s/sqrt(s), the drift of r'; ArVE_d only

    def __post_init__(self) -> None:
        above = ("r_std", "angular_acceleration_std", "gyro_noise_std", "acceleration_noise_std")
        for f in fields(self):
            positive(getattr(self, f.name), f"covariances.{f.name}", or_zero=f.name not in above)

    def initial(self, states: int) -> Array:
        """Return P0 (states, states)."""
        std = (self.r_std, self.gyro_noise_std, self.angular_acceleration_std, self.r_rate_std)
        return np.diag(np.repeat(np.square(std), 3)[:states])

    def process(self, states: int, dt: float) -> Array:
        """Return Q (states, states) of a step of `dt` s: white noise integrated once, and twice one level up."""
        Q = np.zeros((states, states))
        _walk(Q, 6, 3, self.angular_acceleration_density**2, dt)
        Q[R_, R_] += self.r_density**2 * dt * np.eye(3)
        if states == 12:
            _walk(Q, 9, 0, self.r_rate_density**2, dt)
        return Q

    def measurement(self) -> Array:
        """Return R (6, 6)."""
        return np.diag(np.repeat(np.square((self.gyro_noise_std, self.acceleration_noise_std)), 3))


R_, W_, A_, V_ = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)  # r, w, w', r' in the state


def _walk(Q: Array, rate: int, level: int, q: float, dt: float) -> None:
    """Add to Q what white noise of power q does to a rate and its integral in `dt` s."""
    i, j = np.arange(level, level + 3), np.arange(rate, rate + 3)
    Q[i, i] += q * dt**3 / 3
    Q[j, j] += q * dt
    Q[i, j] += q * dt**2 / 2
    Q[j, i] += q * dt**2 / 2


def transition(states: int, dt: float) -> Array:
    """Return F (states, states) of a step of `dt` s."""
    F = np.eye(states)
    F[W_, A_] = dt * np.eye(3)
    if states == 12:
        F[R_, V_] = dt * np.eye(3)
    return F


def expected_acceleration(r: ArrayLike, rate: ArrayLike, angular_acceleration: ArrayLike) -> Array:
    """Return a (..., 3) = -(w' x r) - w x (w x r) in m/s^2, eq. (4), r from the sensor to a joint at rest."""
    r, w, dw = (np.asarray(x, dtype=float) for x in (r, rate, angular_acceleration))
    return np.asarray(-np.cross(dw, r) - np.cross(w, np.cross(w, r)))


Rows = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]


def linearise(state: list[float]) -> tuple[Rows, tuple[float, float, float]]:
    """Return da/d(r, w, w') (3, 9) and a (3,) at a state of floats; plain numbers are faster than arrays of three.

    da/dr = -[w']x - w w^T + |w|^2 I,  da/dw = 2 r w^T - w r^T - (w.r) I,  da/dw' = [r]x.
    """
    rx, ry, rz, wx, wy, wz, ax, ay, az = state[:9]
    xx, yy, zz = wx * wx, wy * wy, wz * wz
    xy, xz, yz = wx * wy, wx * wz, wy * wz
    sx, sy, sz = wx * rx, wy * ry, wz * rz
    top = (yy + zz, az - xy, -ay - xz)
    mid = (-az - xy, xx + zz, ax - yz)
    low = (ay - xz, -ax - yz, xx + yy)
    rows = (
        (*top, -sy - sz, 2 * rx * wy - wx * ry, 2 * rx * wz - wx * rz, 0.0, -rz, ry),
        (*mid, 2 * ry * wx - wy * rx, -sx - sz, 2 * ry * wz - wy * rz, rz, 0.0, -rx),
        (*low, 2 * rz * wx - wz * rx, 2 * rz * wy - wz * ry, -sx - sy, -ry, rx, 0.0),
    )
    (a, b, c), (d, e, f), (g, h, i) = top, mid, low
    return rows, (a * rx + b * ry + c * rz, d * rx + e * ry + f * rz, g * rx + h * ry + i * rz)


class CentreFilter:
    """One sample in, one r out. `states` 9 is ArVE, 12 is ArVE_d.

    r0 is what MrVS makes of the first `initial_samples`; or `r0` (3,) in m as given, and then the filter runs from the
    first sample on. w'0 and r'0 are zero. Time steps count in whole nanoseconds.
    """

    def __init__(
        self, states: int, covariances: Covariances, r0: ArrayLike | None = None, initial_samples: int = INITIAL
    ):
        if initial_samples < 3:
            raise InputError(f"initial_samples: expected 3 or more, got {initial_samples}")
        self.states, self.covariances = states, covariances
        self.r0 = None if r0 is None else frozen(r0, (3,), "r0")
        self.initial_samples = initial_samples
        self.x = np.full(states, np.nan)
        self.P = np.zeros((states, states))
        self.innovation_squared = np.nan  # of the last sample, normalised; chi-square with 6 degrees of freedom
        self._gathered: list[tuple[Array, Array, float]] | None = []
        self._H = np.zeros((6, states))
        self._H[:3, W_] = np.eye(3)
        self._J = self._H[3:, :9]
        self._rhs = np.zeros((6, states + 1), order="F")
        self._dt, self._R = -1.0, covariances.measurement()

    def start(self, r0: ArrayLike, gyro: ArrayLike) -> None:
        """Set the state to r0, the first w, and rest."""
        self.x = np.zeros(self.states)
        self.x[R_], self.x[W_] = r0, gyro
        self.P = self.covariances.initial(self.states)
        self._gathered = None

    def update(self, gyro: Array, acceleration: Array, dt: float) -> Array:
        """Return r (3,) in m after w (3,) in rad/s and a (3,) in m/s^2, `dt` s after the sample before.

        NaN while the first samples are gathered. Raises `InputError` when a number is not finite or dt not positive;
        the filter is then as it was. The dt of the first sample is not used.
        """
        if self._gathered is not None:
            self._gather(gyro, acceleration, dt)
            return self.x[R_]
        dt = round(dt, 9)
        if dt != self._dt:
            self._set_step(dt)
        F, H, rhs = self._F, self._H, self._rhs
        x, P = F.dot(self.x), F.dot(self.P).dot(F.T)  # dot: half the overhead of @ on matrices as small as these
        P += self._Q
        state = x.tolist()
        self._J[:], (ax, ay, az) = linearise(state)
        HP = H.dot(P)
        S = HP.dot(H.T)
        S += self._R
        (gx, gy, gz), (bx, by, bz) = gyro.tolist(), acceleration.tolist()
        rhs[:, :-1] = HP
        rhs[:, -1] = (gx - state[3], gy - state[4], gz - state[5], bx - ax, by - ay, bz - az)
        L, failed = lapack.dpotrf(S, 1)
        whitened, _ = lapack.dtrtrs(L, rhs, 1)
        W, y = whitened[:, :-1], whitened[:, -1]
        squared = float(y.dot(y))
        if failed or not squared < np.inf:
            raise InputError(
                f"joint centre filter: expected finite samples, got gyro {gyro}, acceleration {acceleration}"
            )
        x += y.dot(W)
        P -= W.T.dot(W)
        self.x, self.P, self.innovation_squared = x, P, squared
        return x[R_]

    def _set_step(self, dt: float) -> None:
        if not dt > 0:
            raise InputError(f"joint centre filter: expected a time step > 0 s, got {dt!r}")
        self._F, self._Q = transition(self.states, dt), self.covariances.process(self.states, dt)
        self._dt = dt

    def _gather(self, gyro: Array, acceleration: Array, dt: float) -> None:
        assert self._gathered is not None
        w, a = frozen(gyro, (3,), "gyro"), frozen(acceleration, (3,), "acceleration")
        if self.r0 is not None:
            self.start(self.r0, w)
            return
        if self._gathered and not dt > 0:
            raise InputError(f"joint centre filter: expected a time step > 0 s, got {dt!r}")
        self._gathered.append((w, a, dt))
        if len(self._gathered) == self.initial_samples:
            rates, accelerations, steps = (np.array(x) for x in zip(*self._gathered, strict=True))
            self.start(first_r(rates, accelerations, np.cumsum(steps)), w)


def first_r(gyro: Array, acceleration: Array, time: Array) -> Array:
    """Return r0 (..., 3) in m by MrVS from the first samples (..., n, 3), zero where they do not determine it."""
    return np.nan_to_num(mrvs.solve_differenced(gyro, acceleration, time)[0])


@cache
def stored() -> dict[str, Any]:
    """Return the tables of estimators/arve_covariances.toml: sensor, orientation, and one for each filter."""
    return load_toml(Path(__file__).with_name("arve_covariances.toml"))


def covariances_of(name: str, kind: str = "varying", gravity: How = "pose") -> Covariances:
    """Return the covariances of one filter for an r that is `constant` or `varying`, and a way to take gravity out.

    An orientation that is itself an estimate leaves some of gravity in a, which R then counts as noise.
    """
    tables = stored()
    for what, key, known in (("covariances", kind, tables[name]), ("gravity removal", gravity, tables["orientation"])):
        if key not in known:
            raise unknown(what, key, known)
    sensor, left = tables["sensor"], tables["orientation"][gravity]
    noise = math.hypot(sensor["acceleration_noise_std"], left)
    return Covariances(**{**sensor, "acceleration_noise_std": noise}, **tables[name][kind])
