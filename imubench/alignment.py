"""Does an optical record fit the IMU it came with: the same clock, the same up, the same turning?"""

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.recording import Imu
from imubench.rotations import angle_between, conjugate, log, multiply, rotate

LARGEST_DELAY = 0.1  # s, searched on both sides
FEWEST = 50  # frames in view: a second of any optical system
LARGEST_TILT = np.deg2rad(25.0)  # worst foam mount is 13 deg off; an axis mix-up is 90


def optical_rate(time: Array, quaternion: Array, step: int = 1) -> tuple[Array, Array, Array]:
    """Return starts (m,) s, ends (m,) s and mean angular rates (m, 3) rad/s in segment axes, `step` frames apart."""
    seen = np.asarray(np.isfinite(quaternion).all(axis=-1))
    both = seen[:-step] & seen[step:]
    start, end = time[:-step][both], time[step:][both]
    turn = log(multiply(conjugate(quaternion[:-step][both]), quaternion[step:][both]))
    return start, end, turn / (end - start)[:, None]


def gyro_delay(imu: Imu, time: Array, quaternion: Array) -> tuple[float, float]:
    """Return how late the gyroscope's stamps are against an optical record, and the RMS misfit left.

    `time` (n,) s, `quaternion` (n, 4) segment -> world, NaN where unseen. The delay in s, positive when the
    gyroscope is late, gives the best match of the norms of the angular rate (free of the mount);
    the misfit is theirs, in rad/s. Raises `InputError` when too few frames are in view.
    """
    if time.size < FEWEST or imu.time.size < FEWEST or not (np.diff(time) > 0).all():
        raise InputError(
            f"optical record of {imu.name}: expected {FEWEST} frames and samples or more, in order of time, got "
            f"{time.size} and {imu.time.size}"
        )
    step = max(1, round(1 / (60 * float(np.median(np.diff(time))))))
    start, end, rate = optical_rate(time, quaternion, step)
    inside = (start > imu.time[0] + LARGEST_DELAY) & (end < imu.time[-1] - LARGEST_DELAY)
    if inside.sum() < FEWEST:
        raise InputError(f"optical record of {imu.name}: expected {FEWEST} frames or more in view, got {inside.sum()}")
    start, end, speed = start[inside], end[inside], np.linalg.norm(rate[inside], axis=-1)
    turned = CubicSpline(imu.time, cumulative_trapezoid(imu.gyro, imu.time, axis=0, initial=0))

    def misfit(delay: float) -> float:
        mean_gyro = (turned(end + delay) - turned(start + delay)) / (end - start)[:, None]
        return float(np.sqrt(np.mean((np.linalg.norm(mean_gyro, axis=-1) - speed) ** 2)))

    coarse = np.linspace(-LARGEST_DELAY, LARGEST_DELAY, 41)
    near = coarse[int(np.argmin([misfit(d) for d in coarse]))]
    best = minimize_scalar(misfit, bounds=(near - 0.005, near + 0.005), method="bounded", options={"xatol": 1e-5})
    return float(best.x), float(best.fun)


def check_z_up(imu: Imu, time: Array, quaternion: Array) -> float:
    """Return the tilt in rad of the mean specific force from the optical world's z; `InputError` if z is not up."""
    seen = np.isfinite(quaternion).all(axis=-1) & (time >= imu.time[0]) & (time <= imu.time[-1])
    accel = np.stack([np.interp(time[seen], imu.time, axis) for axis in imu.accel.T], axis=-1)
    up = rotate(multiply(quaternion[seen], imu.mount_quaternion), accel).mean(axis=0)
    tilt = float(angle_between(up, np.array([0.0, 0.0, 1.0])))
    if tilt > LARGEST_TILT:
        raise InputError(
            f"optical record of {imu.name}: expected a world with z up, got a mean specific force of "
            f"{np.round(up, 1).tolist()} m/s^2, {np.rad2deg(tilt):.0f} deg from z"
        )
    return tilt
