"""The part of a recording with most motion on one even grid, small enough for checks that take a second or two."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.nonsense import STRETCH
from imubench.recording import Encoder, Imu, Pose, Recording

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Samples:
    """An IMU's readings, averaged over the intervals of an even grid."""

    time: Array  # (n,) s, the middle of each interval
    gyro: Array  # (n, 3) rad/s
    accel: Array  # (n, 3) m/s^2
    step: float  # s


def averaged(time: Array, values: Array, edges: Array) -> Array:
    """Return the means (n, k) of values (m, k), linear between stamps (m,) s, over the intervals of edges (n + 1,).

    Means, not values: what is faster than the grid averages out and does not come back as something slow.
    """
    area = 0.5 * (values[1:] + values[:-1]) * np.diff(time)[:, None]
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(area, axis=0)])
    at = np.clip(np.searchsorted(time, edges, side="right") - 1, 0, len(time) - 2)
    part = edges - time[at]
    slope = (values[at + 1] - values[at]) / (time[at + 1] - time[at])[:, None]
    whole = total[at] + values[at] * part[:, None] + 0.5 * slope * part[:, None] ** 2
    return np.asarray(np.diff(whole, axis=0) / np.diff(edges)[:, None])


def grid(sensors: Sequence[Array], slowest: float = STRETCH.grid_hz) -> Array:
    """Return the edges (n + 1,) s of an even grid where all of some clocks (m,) s have samples; empty where none is.

    No finer than the slowest clock, at most `STRETCH.grid_hz`.
    """
    start, end = max(float(t[0]) for t in sensors), min(float(t[-1]) for t in sensors)
    step = max(1 / slowest, *(float(np.median(np.diff(t))) for t in sensors))
    count = int((end - start) / step)
    return np.asarray(start + step * np.arange(count + 1 if count > 0 else 0), dtype=float)


def gridded(imu: Imu, edges: Array) -> Samples:
    """Return an IMU's readings on the intervals of even edges (n + 1,) s."""
    step = float(edges[1] - edges[0])
    gyro, accel = averaged(imu.time, imu.gyro, edges), averaged(imu.time, imu.accel, edges)
    return Samples(edges[:-1] + step / 2, gyro, accel, step)


def dense_enough(time: Array) -> bool:
    """Return whether a clock's stamps (n,) s are near enough to each other for the checks."""
    return len(time) > 1 and float(np.median(np.diff(time))) <= 1 / STRETCH.least_rate_hz


def stretch_of_most_motion(recording: Recording, seconds: float) -> Recording:
    """Return the stretch of at most so many seconds in which the IMUs turn most.

    A shorter recording is returned as it is, and one without an IMU.
    """
    if not recording.imus:
        return recording
    clocks = [i.time for i in recording.imus]
    start, end = max(float(t[0]) for t in clocks), min(float(t[-1]) for t in clocks)
    if end - start <= seconds:
        return recording
    begins = np.arange(start, end - seconds, seconds / 4)
    power = np.zeros(len(begins))
    for imu in recording.imus:
        total = np.concatenate([[0.0], np.cumsum(np.sum(imu.gyro**2, axis=1))])
        first, last = (np.searchsorted(imu.time, begins + x) for x in (0.0, seconds))
        power += (total[last] - total[first]) / np.maximum(last - first, 1)
    begin = float(begins[int(np.argmax(power))])
    return cut(recording, begin, begin + seconds)


def cut(recording: Recording, start: float, end: float) -> Recording:
    """Return a recording from one time to another, in s; sensors without two samples there are left out."""

    def inside(time: Array) -> Mask:
        return np.asarray((time >= start) & (time <= end))

    return replace(
        recording,
        imus=tuple(_imu(i, k) for i in recording.imus if (k := inside(i.time)).sum() > 1),
        encoders=tuple(_encoder(e, k) for e in recording.encoders if (k := inside(e.time)).sum() > 1),
        poses=tuple(_pose(p, k) for p in recording.poses if (k := inside(p.time)).sum() > 1),
        free_swings=tuple((max(a, start), min(b, end)) for a, b in recording.free_swings if a < end and b > start),
    )


def _imu(imu: Imu, k: Mask) -> Imu:
    return replace(imu, time=imu.time[k], gyro=imu.gyro[k], accel=imu.accel[k])


def _encoder(encoder: Encoder, k: Mask) -> Encoder:
    return replace(encoder, time=encoder.time[k], angle=encoder.angle[k])


def _pose(pose: Pose, k: Mask) -> Pose:
    position, quaternion = (None if x is None else x[k] for x in (pose.position, pose.quaternion))
    return replace(pose, time=pose.time[k], position=position, quaternion=quaternion)


__all__ = ["Samples", "averaged", "cut", "dense_enough", "grid", "gridded", "stretch_of_most_motion"]
