"""The joint centre from one IMU that slides or hangs on soft tissue: r(t) over a record, or on a stream.

Three kinds of r are fitted, each a constant at its simplest: oscillations of unknown frequency that the accelerometer
feels, the same unfelt, and a spring (sliding_lines.py, sliding_spring.py; equations in sliding_rows.py). The one of the
largest evidence answers. Where nothing moves, that is the constant. Where none explains the samples, there is no
covariance.

What no method can tell: R(t)^T c for a constant c of the world may be added to any felt r(t), since the centre then
still is at rest. A sensor that sags by c is such a case: only a model of why it moves tells r then. docs/soft-tissue.md
"""

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.estimators.gravity import How, linear_acceleration
from imubench.estimators.mrvs import gyro_noise, only_imu, why_unidentifiable
from imubench.estimators.sliding_rows import Rows
from imubench.estimators.sliding_spring import Spring
from imubench.estimators.sliding_stream import (
    FIRST,
    KINDS,
    LEAST_NOISE,
    STREAM,
    UNEXPLAINED,
    WINDOW,
    Fit,
    SlidingStream,
    fitted,
)
from imubench.recording import Imu, Recording

__all__ = [
    "NAME",
    "STREAM",
    "WINDOW",
    "SlidingStream",
    "answer",
    "best",
    "estimate",
    "estimate_stream",
    "fits",
    "rows_of",
]

NAME = "sliding"


def fits(rows: Rows, kinds: tuple[str, ...] = KINDS) -> list[Fit]:
    """Return a fit of each kind, in their order."""
    return [fitted(rows, kind) for kind in kinds]


def best(rows: Rows, kinds: tuple[str, ...] = KINDS) -> Fit:
    """Return the fit of the largest evidence."""
    return max(fits(rows, kinds), key=lambda fit: fit.evidence)


def answer(fit: Fit, time: Array) -> tuple[Array, Array]:
    """Return r (n, 3) in m and its covariance (n, 3, 3) at the samples that were fitted."""
    return (fit.values, fit.covariances) if isinstance(fit, Spring) else fit.r(time)


def rows_of(imu: Imu, acceleration: Array) -> Rows:
    """Return the equations of an IMU's record and its acceleration (n, 3) in m/s^2 without gravity."""
    w = imu.gyro_noise_std if imu.gyro_noise_std is not None else gyro_noise(imu.gyro)
    a = imu.accel_noise_std if imu.accel_noise_std is not None else gyro_noise(imu.accel)
    noise = max(w, LEAST_NOISE), max(a, LEAST_NOISE)
    return Rows(imu.time, imu.gyro, imu.accel, imu.accel - acceleration, *noise)


def estimate(recording: Recording, gravity: How = "ukf", kinds: tuple[str, ...] = KINDS) -> Estimate:
    """Estimate r (n, 1, 3) in m at every sample of a recording with one IMU, from all of it."""
    imu = only_imu(recording, NAME)
    acceleration = linear_acceleration(recording, gravity)
    too_little = why_unidentifiable(imu, acceleration)
    if too_little:  # asked first: fits of next to nothing take longest
        details = {"samples": float(imu.time.size)}
        return Estimate("joint_vector", NAME, np.zeros((1, 3)), None, too_little, "not identifiable", details=details)
    rows = rows_of(imu, acceleration)
    found = fits(rows, kinds)
    fit = max(found, key=lambda one: one.evidence)
    r, covariance = answer(fit, imu.time)
    details = {"samples": float(imu.time.size), "residual_power": fit.noise}
    details |= {f"evidence_{kind}": one.evidence for kind, one in zip(kinds, found, strict=True)}
    if isinstance(fit, Spring):
        details |= {f"spring_frequency_{axis}": f for axis, f in zip("xyz", fit.frequency, strict=True)}
        details["spring_damping"] = fit.damping
    else:
        details |= {f"frequency_{i + 1}": float(f) for i, f in enumerate(fit.frequency)}
    if fit.noise > UNEXPLAINED:
        why = f"no kind of r explains the samples: what is left has {fit.noise:.3g} times the power of the noise"
        return Estimate("joint_vector", NAME, r[:, None], None, why, time=imu.time, details=details)
    return Estimate("joint_vector", NAME, r[:, None], covariance, time=imu.time, details=details)


def estimate_stream(recording: Recording, gravity: How = "ukf", kinds: tuple[str, ...] = KINDS) -> Estimate:
    """Estimate r (n, 1, 3) in m of a recording with one IMU sample by sample, from the past alone."""
    imu = only_imu(recording, STREAM)
    if imu.time[-1] - imu.time[0] < FIRST:
        raise InputError(f"{recording.name}: {STREAM} expected {FIRST:g} s or more, got {np.ptp(imu.time):g} s")
    acceleration = linear_acceleration(recording, gravity)
    rows = rows_of(imu, acceleration)
    stream = SlidingStream(rows.gyro_noise_std, rows.accel_noise_std, kinds)
    r, P = np.empty((imu.time.size, 1, 3)), np.empty((imu.time.size, 3, 3))
    for k, dt in enumerate(np.diff(imu.time, prepend=imu.time[0]).tolist()):
        r[k, 0] = stream.update(imu.gyro[k], imu.accel[k], acceleration[k], dt)
        P[k] = stream.covariance
    seen = np.isfinite(r).all(axis=(1, 2))
    details = {"samples": float(imu.time.size)}
    why = why_unidentifiable(imu, acceleration)
    if why:
        mean = r[seen].mean(axis=0)
        return Estimate("joint_vector", STREAM, mean, None, why, "not identifiable", details=details)
    return Estimate("joint_vector", STREAM, r[seen], P[seen], time=imu.time[seen], details=details)
