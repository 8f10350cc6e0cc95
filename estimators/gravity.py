"""Gravity removal: the acceleration of a sensor from its specific force, with an orientation chosen by name.

a_s = f_s + R_ws^T g_w, eq. (2) of Garcia de Villa et al.; g_w points down. Heading does not matter.
"""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from imubench import rotations
from imubench.arrays import Array
from imubench.errors import InputError, unknown
from imubench.estimators import gravity_numbers as numbers
from imubench.recording import STANDARD_GRAVITY, Imu, Pose, Recording

How = Literal["ukf", "vqf", "vqf-online", "pose"]
HOWS = ("ukf", "vqf", "vqf-online", "pose")
SPREAD = np.sqrt(3.0) * np.concatenate([np.eye(3), -np.eye(3)])  # (6, 3) sigma points of equal weight, cubature


@dataclass(frozen=True)
class UkfSettings:
    """What the filter believes; argued, not fitted: the paper gives none of these."""

    gyro_noise_std: float = 0.0017  # rad/s per sample
    motion_std: float = 2.0  # m/s^2, a limb's own acceleration, which an update takes for noise
    gate: float = 1.0  # m/s^2, by how much |f| may differ from g for an update
    tilt_std: float = 0.25  # rad, of the tilt read off the first sample: motion_std over g, rounded up


class GravityUkf:
    """Orientation from the turn rate, corrected by the specific force when its norm is close to gravity's.

    An unscented Kalman filter after what the paper says of its reference [29], with one change: the error is a
    rotation vector on the right of q_ws instead of Euler angles, which have a pitch where they fail. A turn acts on
    that error linearly, so its unscented transform is written in closed form; only the update draws sigma points.
    Any leading axes are runs side by side. `first` (..., 4) is q_ws at the first sample, good to `tilt_std`; without it
    the first sample's specific force is taken for up, which is as wrong as the limb is already moving.
    """

    def __init__(
        self,
        gravity: float = STANDARD_GRAVITY,
        settings: UkfSettings | None = None,
        first: ArrayLike | None = None,
    ):
        self.gravity, self.settings = gravity, settings or UkfSettings()
        self.first = None if first is None else np.asarray(first, dtype=float)
        self.quaternion: Array | None = None  # (..., 4) sensor -> world, heading arbitrary
        self.covariance: Array = np.zeros((3, 3))  # (..., 3, 3) rad^2, sensor axes
        self._rate: Array = np.zeros(3)  # (..., 3) rad/s, of the last sample

    def update(self, gyro: ArrayLike, accel: ArrayLike, dt: float) -> Array:
        """Return a (..., 3) in m/s^2 after w (..., 3) in rad/s and f (..., 3) in m/s^2; `dt` s since the last sample.

        The turn since the last sample goes by the mean of the two rates: by one of them alone the orientation would be
        half a sample late, 9 mrad at 1.9 rad/s and 100 Hz, or 0.1 m/s^2. The first sample's dt is not used.
        """
        w, f = np.array(gyro, dtype=float), np.asarray(accel, dtype=float)
        if self.quaternion is None:
            self._rate = w
            self.quaternion = upright(f) if self.first is None else np.broadcast_to(self.first, (*f.shape[:-1], 4))
            self.covariance = np.broadcast_to(self.settings.tilt_std**2 * np.eye(3), (*f.shape, 3)).copy()
            return f - self._up(self.quaternion)
        if f.ndim == 1:
            return self._update_one(w, f, dt)
        turn = rotations.exp(dt / 2 * (self._rate + w))
        self._rate = w
        back = rotations.to_matrix(turn)
        self.quaternion = rotations.multiply(self.quaternion, turn)
        noise = (self.settings.gyro_noise_std * dt) ** 2 * np.eye(3)
        self.covariance = np.swapaxes(back, -1, -2) @ self.covariance @ back + noise
        near = np.abs(np.linalg.norm(f, axis=-1) - self.gravity) < self.settings.gate
        if near.any():
            self._correct(f, near)
        return f - self._up(self.quaternion)

    def _update_one(self, w: Array, f: Array, dt: float) -> Array:
        """Update one run, in plain numbers."""
        assert self.quaternion is not None
        (x, y, z), (fx, fy, fz) = (0.5 * dt * (self._rate + w)).tolist(), f.tolist()
        if not math.isfinite(x + y + z + fx + fy + fz):
            raise InputError(f"gravity filter: expected finite samples and steps, got gyro {w}, accel {f}, step {dt} s")
        self._rate = w
        (a, b, c), (d, e, g), (h, i, j) = self.covariance.tolist()
        q: numbers.Four = tuple(self.quaternion.tolist())
        P: numbers.Nine = (a, b, c, d, e, g, h, i, j)
        q, P = numbers.predicted(q, P, (x, y, z), (self.settings.gyro_noise_std * dt) ** 2)
        if abs(math.sqrt(fx * fx + fy * fy + fz * fz) - self.gravity) < self.settings.gate:
            q, P = numbers.corrected(q, P, (fx, fy, fz), self.gravity, self.settings.motion_std**2)
        self.quaternion, self.covariance = np.array(q), np.array(P).reshape(3, 3)
        ux, uy, uz = numbers.up(q, self.gravity)
        return np.array([fx - ux, fy - uy, fz - uz])

    def _up(self, q: Array) -> Array:
        return self.gravity * rotations.to_matrix(q)[..., 2, :]

    def _correct(self, f: Array, near: Array) -> None:
        """Update the runs for which `near` (...) holds; the others keep their state."""
        assert self.quaternion is not None
        P, q = self.covariance, self.quaternion
        errors = SPREAD @ np.swapaxes(np.linalg.cholesky(P), -1, -2)  # (..., 6, 3)
        expected = self._up(rotations.multiply(q[..., None, :], rotations.exp(errors)))
        mean = expected.mean(axis=-2)
        off = expected - mean[..., None, :]
        cross = np.swapaxes(errors, -1, -2) @ off / 6
        S = np.swapaxes(off, -1, -2) @ off / 6 + self.settings.motion_std**2 * np.eye(3)
        gain = np.swapaxes(np.linalg.solve(S, np.swapaxes(cross, -1, -2)), -1, -2) * near[..., None, None]
        step = (gain @ (f - mean)[..., None])[..., 0]
        q = rotations.multiply(q, rotations.exp(step))
        self.quaternion = q / np.linalg.norm(q, axis=-1, keepdims=True)
        P = P - gain @ np.swapaxes(cross, -1, -2)
        half = rotations.to_matrix(
            rotations.exp(step / 2)
        )  # what is left of the error is seen in axes turned by half of it
        P = np.swapaxes(half, -1, -2) @ P @ half
        self.covariance = (P + np.swapaxes(P, -1, -2)) / 2


def upright(f: Array) -> Array:
    """Return the shortest turns q_ws (..., 4) that bring specific forces f (..., 3) up, along world z."""
    size = np.linalg.norm(f, axis=-1, keepdims=True)
    u = f / np.where(size > 0, size, 1.0)
    flipped = u[..., 2:] < -1 + 1e-12
    half = np.concatenate([1 + u[..., 2:], u[..., 1:2], -u[..., :1], np.zeros_like(u[..., :1])], axis=-1)
    half = np.where(flipped, np.array([0.0, 1.0, 0.0, 0.0]), half)
    return np.asarray(half / np.linalg.norm(half, axis=-1, keepdims=True))


def remove_by_ukf(
    gyro: ArrayLike,
    accel: ArrayLike,
    time: ArrayLike,
    gravity: float = STANDARD_GRAVITY,
    settings: UkfSettings | None = None,
    first: ArrayLike | None = None,
) -> Array:
    """Return a (..., n, 3) in m/s^2 of samples w, f (..., n, 3) at `time` (n,) s; leading axes are runs."""
    w, f, t = (np.asarray(x, dtype=float) for x in (gyro, accel, time))
    ukf = GravityUkf(gravity, settings, first)
    steps = np.diff(t, prepend=t[:1])
    return np.stack([ukf.update(w[..., k, :], f[..., k, :], dt) for k, dt in enumerate(steps.tolist())], axis=-2)


def linear_acceleration(
    recording: Recording, how: How = "ukf", name: str = "imu1", settings: UkfSettings | None = None
) -> Array:
    """Return the acceleration (n, 3) in m/s^2 of one IMU in its own axes, gravity taken out.

    `how`: "ukf", the filter above; "vqf", VQF looking both ways in time; "vqf-online", VQF as samples come; "pose",
    the recording's own pose sensor on that IMU's segment with the declared mount, which is how a caller chooses a
    measured or a true orientation. Raises `InputError` for an unknown name, or a recording that lacks what is needed.
    """
    imu = recording.imu(name)
    if how == "ukf":
        if settings is None and imu.gyro_noise_std is not None:
            settings = UkfSettings(gyro_noise_std=imu.gyro_noise_std)
        return remove_by_ukf(imu.gyro, imu.accel, imu.time, recording.gravity, settings)
    if how in ("vqf", "vqf-online"):
        q_ws = _vqf(imu, both_ways=how == "vqf")
    elif how == "pose":
        q_ws = _posed(recording, imu)
    else:
        raise unknown("gravity removal", how, HOWS)
    return imu.accel - recording.gravity * rotations.to_matrix(q_ws)[:, 2, :]


def _vqf(imu: Imu, both_ways: bool) -> Array:
    """Return q_ws (n, 4) by VQF (Laidig, Seel 2023), without magnetometer, with its default parameters."""
    try:
        import vqf
    except ImportError:
        raise InputError(
            "gravity removal by vqf needs the package vqf: pip install 'imubench[filters]', or choose ukf or pose"
        ) from None
    steps = np.diff(imu.time)
    step = float(np.median(steps)) if steps.size else 1 / imu.rate
    if steps.size and steps.max() > 1.5 * step:
        row = int(np.argmax(steps)) + 1
        raise InputError(
            f"{imu.name}: vqf expected evenly spaced samples {step:g} s apart, got {steps.max():g} s before row {row}; "
            "choose ukf or pose"
        )
    gyro, accel = np.array(imu.gyro), np.array(imu.accel)  # vqf wants writable arrays
    gyro[1:] += imu.gyro[:-1]  # the turn between two samples goes by the mean of their rates, see `GravityUkf`
    gyro[1:] /= 2
    answer: Any = vqf.offlineVQF(gyro, accel, None, step) if both_ways else vqf.VQF(step).updateBatch(gyro, accel)
    return np.asarray(answer["quat6D"], dtype=float)


def _posed(recording: Recording, imu: Imu) -> Array:
    """Return q_ws (n, 4) from the pose sensor of the IMU's segment, interpolated on the sphere, times its mount."""
    segment = f"segment{imu.name.removeprefix('imu')}"
    pose = next((p for p in recording.poses if p.segment == segment and p.quaternion is not None), None)
    if pose is None:
        raise InputError(f"{recording.name}: gravity removal by pose expected a pose of {segment} with quaternions")
    time, q = _seen(pose)
    if time.size < 2 or imu.time[0] < time[0] - 1e-9 or imu.time[-1] > time[-1] + 1e-9:
        span = f"{time[0]:g} to {time[-1]:g} s" if time.size else "none"
        raise InputError(
            f"{recording.name}: expected a pose of {segment} from {imu.time[0]:g} to {imu.time[-1]:g} s, got {span}"
        )
    k = np.clip(np.searchsorted(time, imu.time, side="right") - 1, 0, time.size - 2)
    part = (imu.time - time[k]) / (time[k + 1] - time[k])
    turn = rotations.log(rotations.multiply(rotations.conjugate(q[k]), q[k + 1]))
    return rotations.multiply(rotations.multiply(q[k], rotations.exp(part[:, None] * turn)), imu.mount_quaternion)


def _seen(pose: Pose) -> tuple[Array, Array]:
    """Return the stamps and unit quaternions of the samples of a pose that were seen."""
    assert pose.quaternion is not None
    seen = np.isfinite(pose.quaternion).all(axis=1)
    q = pose.quaternion[seen]
    return pose.time[seen], q / np.linalg.norm(q, axis=1, keepdims=True)
