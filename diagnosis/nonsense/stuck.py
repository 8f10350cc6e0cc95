"""Channels that read one number while their sensor moves.

A channel that never changes has not even noise. It may be at rest, with readings rounded to coarse steps; it may be at
the end of its range. It is stuck if something else shows that what it measures did change: the other axes of its
triple, which read something new in nearly every sample; gravity, for a gyroscope, or the gyroscope, for an
accelerometer; the sensors beside an IMU of which nothing changes at all.
"""

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from imubench.arrays import Array
from imubench.diagnosis.config.nonsense import SHARED_MOTION, STUCK
from imubench.diagnosis.nonsense.different_motions import rate_across_axis, rate_of
from imubench.diagnosis.nonsense.stretch import grid
from imubench.diagnosis.result import Nonsense
from imubench.recording import Imu, Recording

SENSOR_WORDS: Mapping[str, str] = {"gyro": "gyroscope", "accel": "accelerometer"}
CHANNELS = {"gyro": ("gyr_x", "gyr_y", "gyr_z"), "accel": ("acc_x", "acc_y", "acc_z")}

Mask = NDArray[np.bool_]


def stuck(recording: Recording) -> Iterator[Nonsense]:
    """Yield every IMU, triple or axis that is stuck."""
    for imu in recording.moving:
        held = {part: repeating(imu.time, getattr(imu, part)) for part in SENSOR_WORDS}
        whole = np.hstack([held["gyro"], held["accel"]]).all(axis=1)
        if whole.mean() > STUCK.most:
            yield from _whole(recording, imu, np.asarray(whole))
            continue
        for part, at in held.items():
            yield from _triple(imu, part, at)


def repeating(time: Array, values: Array) -> Mask:
    """Return which readings (n, k) belong to `STUCK.long_s` seconds or more of one number."""
    out = np.zeros(values.shape, dtype=bool)
    for axis, x in enumerate(values.T):
        new = np.flatnonzero(np.concatenate([[True], x[1:] != x[:-1]]))
        last = np.append(new[1:], len(x)) - 1
        for a, b in zip(new, last, strict=True):
            out[a : b + 1, axis] = time[b] - time[a] >= STUCK.long_s
    return out


def _whole(recording: Recording, imu: Imu, at: Mask) -> Iterator[Nonsense]:
    """Yield that nothing of an IMU changes, if something beside it moves, or if it never does."""
    share, channels = float(at.mean()), (*CHANNELS["gyro"], *CHANNELS["accel"])
    if carried(recording, imu):
        what = f"{imu.name} is stuck: it reads the same {_how_long(share)}, while the rig moves"
        yield Nonsense(imu.name, what, {"share": share}, channels, _advice(imu))
    elif at.all():
        what = f"{imu.name} reads the same in every sample: it is stuck, or nothing moves"
        yield Nonsense(imu.name, what, {"share": share}, channels, _advice(imu), missing=True)


def carried(recording: Recording, imu: Imu) -> bool:
    """Return whether another sensor shows that an IMU's segment turns: what turns about two axes takes both along."""
    for other in recording.imus:
        if (
            other.name != imu.name
            and recording.tree.hinge is not None
            and rate_across_axis(other.gyro) > SHARED_MOTION.turning_rad_s
        ):
            return True
    poses = [rate_of(p)[1] for p in recording.poses if p.quaternion is not None]
    turning = [float(np.sqrt(np.mean(np.sum(w**2, axis=1)))) for w in poses if len(w)]
    return any(w > SHARED_MOTION.turning_rad_s for w in turning)


def _triple(imu: Imu, part: str, held: Mask) -> Iterator[Nonsense]:
    """Yield that a triple of an IMU is stuck, or that some of its axes are."""
    values: Array = getattr(imu, part)
    dead = [k for k in range(3) if held[:, k].mean() > STUCK.most and not at_limit(imu, part, k)]
    if len(dead) == 3:
        at = np.asarray(held.all(axis=1))
        moves = turning_force(imu, at) > STUCK.turned_rad if part == "gyro" else rms_rate(imu, at) > STUCK.turning_rad_s
        if at.mean() > STUCK.most and moves:
            what = f"{imu.name}'s {SENSOR_WORDS[part]} is stuck: it reads the same {_how_long(float(at.mean()))}"
            yield Nonsense(imu.name, what, {"share": float(at.mean())}, CHANNELS[part], _advice(imu))
        return
    busy = [k for k in range(3) if k not in dead and np.mean(values[1:, k] != values[:-1, k]) > STUCK.most]
    if dead and busy:
        names = tuple(CHANNELS[part][k] for k in dead)
        share = float(held[:, dead].all(axis=1).mean())
        verb = "is stuck: it reads" if len(names) == 1 else "are stuck: they read"
        what = f"{' and '.join(names)} of {imu.name} {verb} the same {_how_long(share)}"
        yield Nonsense(imu.name, what, {"share": share}, names, _advice(imu))


def at_limit(imu: Imu, part: str, axis: int) -> bool:
    """Return whether an axis that reads one number is clipped: at its declared range, or where others end too."""
    values: Array = getattr(imu, part)
    numbers, counts = np.unique(np.abs(values[:, axis]), return_counts=True)
    limit = float(numbers[int(np.argmax(counts))])
    known = imu.gyro_range if part == "gyro" else imu.accel_range
    if known is not None and limit >= known * (1 - STUCK.same_limit):
        return True
    others = np.abs(np.delete(values, axis, axis=1))
    ends = np.abs(others - limit) <= STUCK.same_limit * limit
    return limit > 0 and bool((ends.sum(axis=0) >= 3).any()) and float(others.max()) <= limit * (1 + STUCK.same_limit)


def turning_force(imu: Imu, at: Mask) -> float:
    """Return the largest angle in rad between directions of the specific force, a second's mean each."""
    edges = grid([imu.time])
    width = max(1, round(STUCK.long_s / float(edges[1] - edges[0] if edges.size > 1 else STUCK.long_s)))
    force = uniform_filter1d(imu.accel, min(width, len(imu.time)), axis=0)[at]
    size = np.linalg.norm(force, axis=1, keepdims=True)
    force = force / np.maximum(size, 1e-12)
    mean = force.mean(axis=0) / max(float(np.linalg.norm(force.mean(axis=0))), 1e-12)
    return float(np.arccos(np.clip(force @ mean, -1, 1)).max()) if len(force) else 0.0


def rms_rate(imu: Imu, at: Mask) -> float:
    """Return how fast an IMU turns, in rad/s RMS."""
    return float(np.sqrt(np.mean(np.sum(imu.gyro[at] ** 2, axis=1)))) if at.any() else 0.0


def _how_long(share: float) -> str:
    return "in every sample" if share > 0.999 else f"for {100 * share:.0f} % of the recording"


def _advice(imu: Imu) -> str:
    return f"check {imu.name} and how it was read out"


__all__ = ["repeating", "stuck"]
