"""Recordings of which one thing is made wrong, and what is said of them."""

from dataclasses import replace

import numpy as np

from imubench.recording import Recording

I = np.eye(3)  # noqa: E741  # the identity, as in the equations

RIGS = {
    "hinge": {"rig": "hinge"},
    "fixed": {"rig": "hinge", "base": "fixed"},
    "swing": {"rig": "hinge", "base": "fixed", "swing": True},
    "pendulum": {"rig": "pendulum"},
    "free": {"rig": "free"},
    "encoder": {"rig": "hinge", "encoder": True},
}


def changed(recording: Recording, at: str, gyro=I, accel=I) -> Recording:
    """The recording with an IMU that reports matrices times what it should."""
    return replace(
        recording,
        imus=tuple(
            replace(i, gyro=i.gyro @ gyro.T, accel=i.accel @ accel.T) if i.name == at else i for i in recording.imus
        ),
    )


def flip(*axes: int) -> np.ndarray:
    return np.diag([-1.0 if k in axes else 1.0 for k in range(3)])


def of_two(one: Recording, other: Recording) -> Recording:
    """The first recording with the second IMU of another one."""
    later = other.imus[1]
    return replace(
        one, imus=(one.imus[0], replace(later, time=later.time - later.time[0] + one.imus[0].time[0])), encoders=()
    )


def with_imu(recording: Recording, at: str, **parts) -> Recording:
    return replace(recording, imus=tuple(replace(i, **parts) if i.name == at else i for i in recording.imus))


def held(values: np.ndarray, columns, start: int = 0) -> np.ndarray:
    out = values.copy()
    out[start:, columns] = out[start, columns]
    return out


def said(found) -> list[str]:
    return [n.what for n in found]
