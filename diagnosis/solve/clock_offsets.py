"""How far clocks are apart before any fit, from what two sensors must both see."""

from collections.abc import Mapping
from contextlib import suppress

import numpy as np
from scipy.ndimage import gaussian_filter1d

from imubench.alignment import gyro_delay
from imubench.arrays import Array
from imubench.diagnosis.config.solve import START
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.rig_kinematics import HINGE_AXIS
from imubench.errors import InputError
from imubench.recording import Imu, Pose, Recording


def late(model: Model) -> dict[str, float]:
    """Return by how much the stamps of IMUs are late, in s, against an encoder, a measured pose or the first IMU."""
    recording, rig, imus = model.recording, model.rig, {i.name: i for i in model.recording.imus}
    out: dict[str, float] = {}
    if (pair := rig.tree.pair) is not None:
        one, two = pair
        if one in imus and two in imus:
            out[two] = clock_offset(model, imus[one], imus[two])
        if recording.encoders and two in imus:
            every = encoder_offset(model, imus, pair, out.get(two, 0.0))
            out = {n: out.get(n, 0.0) + every for n in imus if rig.turns or n == two}
    first = rig.tree.imus[0]
    if recording.poses and list(imus) == [first]:
        out[first] = pose_offset(imus[first], recording.poses[0])
    return out


def coarse(recording: Recording) -> float:
    """Return from which offset on, in s, a clock is in the fit from the start."""
    return START.linear_pose_offset_s if recording.poses and len(recording.imus) == 1 else START.linear_offset_s


def on_segment(model: Model, imu: Imu, grid: Array, offset: float) -> tuple[Array, Array]:
    """Return rate and specific force of an IMU in segment axes, on the grid."""
    stamps = imu.time - model.start - offset
    turn = model.mounts[imu.name].turn
    gyro, accel = (np.stack([np.interp(grid, stamps, x) for x in y.T], axis=1) for y in (imu.gyro, imu.accel))
    return gyro @ turn.T, accel @ turn.T


def on_segments(model: Model, grid: Array, offsets: Mapping[str, float]) -> dict[str, tuple[Array, Array]]:
    """Return rate and specific force of every IMU in segment axes, on the grid, where stamps are late by `offsets`."""
    return {i.name: on_segment(model, i, grid, offsets.get(i.name, 0.0)) for i in model.recording.imus}


def clock_offset(model: Model, one: Imu, two: Imu) -> float:
    """Return by how much the second IMU's stamps are late, in s, from what a hinge leaves equal: |w x j|."""
    step = 0.2 / max(one.rate, two.rate)
    grid = np.arange(0.0, min(one.time[-1], two.time[-1]) - model.start, step)
    gyros = [on_segment(model, imu, grid, 0.0)[0] for imu in (one, two)]
    a, b = (np.linalg.norm(np.delete(g, HINGE_AXIS, axis=1), axis=1) for g in gyros)
    return lag(a, b, step)


def encoder_offset(model: Model, imus: Mapping[str, Imu], pair: tuple[str, str], behind: float) -> float:
    """Return by how much all IMUs' stamps are late, in s, against an encoder, the second's `behind` more."""
    encoder, step = model.recording.encoders[0], 0.2 / max(i.rate for i in imus.values())
    first = max(t[0] for t in (encoder.time, *(i.time for i in imus.values())))
    last = min(t[-1] for t in (encoder.time, *(i.time for i in imus.values())))
    grid = np.arange(first, last, step) - model.start
    one, two = pair
    about = {n: on_segment(model, i, grid, behind if n == two else 0.0)[0][:, HINGE_AXIS] for n, i in imus.items()}
    still = np.zeros(len(grid))
    turned = np.interp(grid, encoder.time - model.start, encoder.angle)
    width = round(START.rate_window_s / step)  # an encoder's steps are no motion
    rate = np.gradient(gaussian_filter1d(turned, width), step)
    return lag(rate, gaussian_filter1d(about[two] - about.get(one, still), width), step)


def lag(one: Array, two: Array, step: float) -> float:
    """Return by how much the second of two signals (n,) is late, in s; 0 where they are not alike enough to tell."""
    a, b = (x - x.mean() for x in (one, two))
    lags = np.arange(-int(START.most_offset_s / step), int(START.most_offset_s / step) + 1)
    edge = len(lags)
    if len(a) < 3 * edge:
        return 0.0
    inner = a[edge:-edge]
    shifted = [b[edge + k : len(b) - edge + k] for k in lags]
    apart = np.array([np.var(inner - x) for x in shifted])  # a product would grow with what else comes into the window
    best = int(np.argmin(apart))
    if best in (0, len(lags) - 1) or not np.corrcoef(inner, shifted[best])[0, 1] > START.least_correlation:
        return 0.0
    y = apart[best - 1 : best + 2]
    curve = y[0] - 2 * y[1] + y[2]
    return float((lags[best] + (0.5 * (y[0] - y[2]) / curve if curve else 0.0)) * step)


def pose_offset(imu: Imu, pose: Pose) -> float:
    """Return by how much an IMU's stamps are late, in s, against a measured attitude; 0 where that is not enough."""
    if pose.quaternion is None:
        return 0.0
    with suppress(InputError):
        return gyro_delay(imu, pose.time, pose.quaternion)[0]
    return 0.0


__all__ = ["clock_offset", "coarse", "late", "on_segments", "pose_offset"]
