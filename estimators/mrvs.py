"""MrVS: one r by least squares, for a whole record or in a sliding window.

Garcia de Villa et al., section III-B, after Crabolu et al. With r from the sensor to a joint centre at rest and w' from
the difference of the gyroscope, every sample says M(w, w') r = -a (docs/joint-centre.md has the signs).
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.estimators.extent import too_short
from imubench.estimators.gravity import How, linear_acceleration
from imubench.recording import Imu, Recording

UNKNOWNS = 3  # r
WINDOW = 45  # samples, the trade-off of section IV-C
SHAKEN = 10.0  # times what noise alone puts into M^T M, for r to count as identifiable
STILL = "the IMU turned too little, or about one axis only: noise alone could fill the least squares"


def lever_matrix(rate: ArrayLike, angular_acceleration: ArrayLike) -> Array:
    """Return M (..., 3, 3) of eq. (6), M r = w' x r + w x (w x r), for w (..., 3) in rad/s and w' in rad/s^2."""
    w, dw = np.asarray(rate, dtype=float), np.asarray(angular_acceleration, dtype=float)
    matrix = w[..., :, None] * w[..., None, :]
    square = np.sum(w * w, axis=-1)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        matrix[..., i, i] -= square
        matrix[..., k, j] += dw[..., i]
        matrix[..., j, k] -= dw[..., i]
    return matrix


def central_difference(gyro: ArrayLike, time: ArrayLike) -> Array:
    """Return w' (..., n - 2, 3) in rad/s^2 at the inner samples of gyro (..., n, 3), from both neighbours."""
    w, t = np.asarray(gyro, dtype=float), np.asarray(time, dtype=float)
    return (w[..., 2:, :] - w[..., :-2, :]) / (t[2:] - t[:-2])[:, None]


@dataclass(frozen=True)
class Sums:
    """Normal equations N r = -b of samples, and the squares of what they explain; leading axes as given."""

    N: Array  # (..., 3, 3), sum of M^T M
    b: Array  # (..., 3), sum of M^T a
    aa: Array  # (...), sum of a^T a
    count: int  # samples in each

    def solve(self) -> tuple[Array, Array]:
        """Return r (..., 3) in m and its covariance (..., 3, 3); NaN where M has lost rank.

        The covariance is that of least squares with the scatter of the residuals. It knows of white noise in a;
        noise in w' enters M too and draws r towards zero, which it does not know.
        """
        scale = np.trace(self.N, axis1=-2, axis2=-1) / 3
        regular = np.linalg.det(self.N) > 1e-15 * scale**3  # at 1e-16 det is rounding
        N = np.where(regular[..., None, None], self.N, np.eye(3))
        inverse: Array = np.linalg.inv(N)
        r = -np.linalg.solve(N, self.b[..., None])[..., 0]
        residual = np.maximum(self.aa + np.sum(r * self.b, axis=-1), 0.0) / max(3 * self.count - 3, 1)
        lost = np.where(regular, 1.0, np.nan)
        return np.asarray(r * lost[..., None]), np.asarray(inverse * (lost * residual)[..., None, None])


def sums(rate: ArrayLike, angular_acceleration: ArrayLike, acceleration: ArrayLike, window: int | None = None) -> Sums:
    """Sum the normal equations of samples w, w', a, each (..., n, 3), over all of them or every `window` of them.

    With a window the answer has an axis (..., n - window + 1) of windows. `InputError` if it is longer than n.
    """
    M, a = lever_matrix(rate, angular_acceleration), np.asarray(acceleration, dtype=float)
    n = a.shape[-2]
    MT = np.swapaxes(M, -1, -2)
    terms = MT @ M, (MT @ a[..., None])[..., 0], np.sum(a * a, axis=-1)
    if window is None:
        return Sums(terms[0].sum(axis=-3), terms[1].sum(axis=-2), terms[2].sum(axis=-1), n)
    if not 1 <= window <= n:
        raise InputError(f"window: expected 1 to {n} samples, got {window}")
    N, b, aa = (_moving_sum(x, a.ndim - 2, window) for x in terms)
    return Sums(N, b, aa, window)


def _moving_sum(x: Array, axis: int, window: int) -> Array:
    total = np.cumsum(x, axis=axis)
    total = np.concatenate([np.zeros_like(total.take([0], axis)), total], axis=axis)
    n = total.shape[axis]
    return np.asarray(total.take(range(window, n), axis) - total.take(range(n - window), axis))


def solve(rate: ArrayLike, angular_acceleration: ArrayLike, acceleration: ArrayLike) -> tuple[Array, Array]:
    """Return r (..., 3) in m and its covariance from samples w, w', a (..., n, 3) in sensor axes, w' as supplied."""
    return sums(rate, angular_acceleration, acceleration).solve()


def solve_differenced(gyro: ArrayLike, acceleration: ArrayLike, time: ArrayLike) -> tuple[Array, Array]:
    """Return r (..., 3) and its covariance from samples (..., n, 3) at `time` (n,) s, w' by central difference."""
    return solve(*_inner(gyro, acceleration, time))


def solve_windows(gyro: ArrayLike, acceleration: ArrayLike, time: ArrayLike, window: int) -> tuple[Array, Array]:
    """Return r (..., n - window - 1, 3) and covariances of every window of inner samples, w' by central difference.

    Row i has used samples i to i + window + 1, so it can be had at the last of these; NaN where M has lost rank.
    """
    return sums(*_inner(gyro, acceleration, time), window=window).solve()


def _inner(gyro: ArrayLike, acceleration: ArrayLike, time: ArrayLike) -> tuple[Array, Array, Array]:
    w, a = np.asarray(gyro, dtype=float), np.asarray(acceleration, dtype=float)
    return w[..., 1:-1, :], central_difference(w, time), a[..., 1:-1, :]


class WindowMrvs:
    """MrVS in a sliding window, one sample in, one r out: the numbers of `solve_windows`, as they come."""

    def __init__(self, window: int = WINDOW):
        if window < 1:
            raise InputError(f"window: expected 1 sample or more, got {window}")
        self._samples: deque[tuple[float, Array, Array]] = deque(maxlen=3)
        self._terms = np.empty((window, 13))  # of each sample in the window M^T M, M^T a and a^T a
        self._count = 0

    def update(self, gyro: ArrayLike, acceleration: ArrayLike, time: float) -> Array:
        """Return r (3,) in m after w (3,) in rad/s and a (3,) in m/s^2 at `time` s; NaN until the window is full."""
        self._samples.append((time, np.array(gyro, dtype=float), np.array(acceleration, dtype=float)))
        window = len(self._terms)
        if len(self._samples) == 3:
            (before, w0, _), (_, w, a), (after, w1, _) = self._samples
            M = lever_matrix(w, (w1 - w0) / (after - before))
            term = self._terms[self._count % window]
            term[:9], term[9:12], term[12] = (M.T @ M).ravel(), M.T @ a, a @ a
            self._count += 1
        if self._count < window:
            return np.full(3, np.nan)
        total = self._terms.sum(axis=0)
        return Sums(total[:9].reshape(3, 3), total[9:12], np.asarray(total[12]), window).solve()[0]


def only_imu(recording: Recording, name: str) -> Imu:
    """Return the one IMU of a recording; `InputError` for more or fewer: one IMU needs a joint at rest."""
    if len(recording.imus) != 1:
        names = ", ".join(imu.name for imu in recording.imus) or "none"
        raise InputError(f"{recording.name}: {name} expected one IMU on a limb whose joint rests, got {names}")
    return recording.imus[0]


def why_unidentifiable(imu: Imu, acceleration: Array) -> str:
    """Return why the samples of an IMU cannot tell r: too few, or it turned too little. Empty where they can."""
    return too_short(imu.time, UNKNOWNS) or ("" if identifiable(imu, acceleration) else STILL)


def identifiable(imu: Imu, acceleration: Array) -> bool:
    """Tell whether the IMU turned enough, and about enough axes, for the least squares to be about r.

    Gyroscope noise s alone makes M^T M regular: each sample then adds 2 s'^2 to every direction, s' that of w' by
    central difference. Ten times that is asked for in the weakest direction.
    """
    if imu.time.size < 5:
        return False
    s = imu.gyro_noise_std if imu.gyro_noise_std is not None else gyro_noise(imu.gyro)
    step = float(np.median(np.diff(imu.time)))
    values = np.linalg.eigvalsh(sums(*_inner(imu.gyro, acceleration, imu.time)).N)
    return bool(values[0] > max(SHAKEN * 2 * (imu.time.size - 2) * s**2 / (2 * step**2), 1e-12 * values[-1]))


def gyro_noise(gyro: Array) -> float:
    """Return the std per sample of white noise in gyro (n, 3), from its third differences (variance 20 s^2)."""
    return float(np.median(np.abs(np.diff(gyro, 3, axis=0))) / 0.6745 / np.sqrt(20))


def estimate(recording: Recording, gravity: How = "ukf") -> Estimate:
    """Estimate one r (1, 3) in m over the whole record of a recording with one IMU."""
    imu = only_imu(recording, "mrvs")
    if imu.time.size < 3:
        raise InputError(f"{recording.name}: mrvs expected 3 samples or more, got {imu.time.size}")
    acceleration = linear_acceleration(recording, gravity)
    r, covariance = solve_differenced(imu.gyro, acceleration, imu.time)
    details = {"samples": float(imu.time.size)}
    why = why_unidentifiable(imu, acceleration) or ("" if np.isfinite(r).all() else STILL)
    if why:
        return Estimate("joint_vector", "mrvs", np.nan_to_num(r)[None], None, why, "not identifiable", None, details)
    return Estimate("joint_vector", "mrvs", r[None], covariance, details=details)


def estimate_window(recording: Recording, gravity: How = "ukf", window: int = WINDOW) -> Estimate:
    """Estimate r (n, 1, 3) in m in a sliding window, at the stamps of the samples that complete one."""
    imu = only_imu(recording, "mrvs-window")
    if imu.time.size < window + 2:
        raise InputError(f"{recording.name}: mrvs-window expected {window + 2} samples or more, got {imu.time.size}")
    acceleration = linear_acceleration(recording, gravity)
    r, covariance = solve_windows(imu.gyro, acceleration, imu.time, window)
    solved = np.isfinite(r).all(axis=-1)
    details = {"samples": float(imu.time.size), "window": float(window), "windows_without_rank": float((~solved).sum())}
    time = imu.time[window + 1 :][solved]
    why = why_unidentifiable(imu, acceleration) or ("" if solved.any() else STILL)
    if why:
        mean = r[solved].mean(axis=0) if solved.any() else np.zeros(3)
        return Estimate("joint_vector", "mrvs-window", mean[None], None, why, "not identifiable", None, details)
    return Estimate("joint_vector", "mrvs-window", r[solved][:, None], covariance[solved], time=time, details=details)
