"""An `Estimate` from a recording by one of the filters of the joint centre."""

import numpy as np

from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.estimators.centre_ekf import CentreFilter
from imubench.estimators.gravity import How, linear_acceleration
from imubench.estimators.mrvs import only_imu, why_unidentifiable
from imubench.recording import Recording


def answer(name: str, centre: CentreFilter, recording: Recording, gravity: How) -> Estimate:
    """Return r (n, 1, 3) in m at the stamps from which `centre`, a filter not yet started, has an answer.

    Its covariance is the filter's. Raises `InputError` for other than one IMU, or fewer samples than it starts with.
    """
    imu = only_imu(recording, name)
    first = 0 if centre.r0 is not None else centre.initial_samples - 1
    if imu.time.size <= first:
        raise InputError(f"{recording.name}: {name} expected {first + 1} samples or more, got {imu.time.size}")
    acceleration = linear_acceleration(recording, gravity)
    n = imu.time.size
    r, P, squares = np.empty((n, 1, 3)), np.empty((n, 3, 3)), np.empty(n)
    for k, dt in enumerate(np.diff(imu.time, prepend=imu.time[0]).tolist()):
        r[k, 0] = centre.update(imu.gyro[k], acceleration[k], dt)
        P[k], squares[k] = centre.P[:3, :3], centre.innovation_squared
    details = {"samples": float(n)}
    if n > first + 1:
        details["innovation_squared"] = float(squares[first + 1 :].mean() / 6)  # 1 if its assumptions hold
    why = why_unidentifiable(imu, acceleration)
    if why:
        last = r[first:].mean(axis=0)
        return Estimate("joint_vector", name, last, None, why, "not identifiable", details=details)
    return Estimate("joint_vector", name, r[first:], P[first:], time=imu.time[first:], details=details)
