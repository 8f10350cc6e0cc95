"""Two IMUs of a recording on one clock."""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array, frozen, frozen_time
from imubench.errors import InputError
from imubench.recording import Imu, Recording

LONGEST_GAP = 2.5  # nominal periods that are still interpolated across


@dataclass(frozen=True)
class Paired:
    """Simultaneous samples of imu1 and imu2, each in its own sensor axes."""

    time: Array  # (n,) s
    gyro1: Array  # (n, 3) rad/s
    accel1: Array  # (n, 3) m/s^2
    gyro2: Array  # (n, 3) rad/s
    accel2: Array  # (n, 3) m/s^2

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", frozen_time(self.time, "paired.time"))
        for key in ("gyro1", "accel1", "gyro2", "accel2"):
            object.__setattr__(self, key, frozen(getattr(self, key), (self.time.size, 3), f"paired.{key}"))


def paired(recording: Recording) -> Paired:
    """Bring imu1 and imu2 onto one clock, where both have samples.

    Equal stamps are left as they are. Otherwise the IMU of the higher nominal rate, or imu2 if they are
    alike, is interpolated linearly at the other's stamps, but not across gaps of over 2.5 periods.
    Raises `InputError` with fewer than two IMUs or no common samples.
    """
    if len(recording.imus) < 2:
        names = ", ".join(imu.name for imu in recording.imus) or "none"
        raise InputError(f"{recording.name}: expected two IMUs, got {names}")
    one, two = recording.imu("imu1"), recording.imu("imu2")
    if np.array_equal(one.time, two.time):
        return Paired(one.time, one.gyro, one.accel, two.gyro, two.accel)
    faster, slower = (one, two) if one.rate > two.rate else (two, one)
    keep = _covered(faster, slower.time)
    if not keep.any():
        raise InputError(f"{recording.name}: expected imu1 and imu2 to have samples at common times, got none")
    time = slower.time[keep]
    sampled = {faster.name: _at(faster, time), slower.name: (slower.gyro[keep], slower.accel[keep])}
    return Paired(time, *sampled["imu1"], *sampled["imu2"])


def _covered(imu: Imu, time: Array) -> Array:
    """Tell which times (n,) lie on a sample of `imu` or between two that are not a gap apart."""
    after = np.searchsorted(imu.time, time, side="left").clip(0, imu.time.size - 1)
    before = (np.searchsorted(imu.time, time, side="right") - 1).clip(0)
    inside = (time >= imu.time[0]) & (time <= imu.time[-1])
    return np.asarray(inside & (imu.time[after] - imu.time[before] <= LONGEST_GAP / imu.rate))


def _at(imu: Imu, time: Array) -> tuple[Array, Array]:
    columns = [np.interp(time, imu.time, column) for column in (*imu.gyro.T, *imu.accel.T)]
    return np.stack(columns[:3], axis=1), np.stack(columns[3:], axis=1)
