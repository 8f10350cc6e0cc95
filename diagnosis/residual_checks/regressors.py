"""What the segments did, as magnitudes that a mismatch may go with."""

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.residuals import LOCALIZE
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.rig_kinematics import HINGE
from imubench.diagnosis.residual_checks.localize import Regressors


def regressors(fit: Fit) -> dict[str, Regressors]:
    """Return angular rate, angular acceleration, specific force beyond its mean, hinge angle and reversals by IMU."""
    model = fit.model
    out = {}
    for imu in model.recording.imus:
        time = np.arange(imu.time[0], imu.time[-1], 1 / LOCALIZE.grid_hz)
        moment = model.moment(fit.state, time, imu.name)
        segments = model.segments(fit.state, moment)
        segment = segments[model.recording.carrier(imu.name)]
        sensor = segment.child(model.mount(imu, fit.state, moment, segment))
        size = {
            "angular rate": sensor.rate.value,
            "angular acceleration": sensor.accel.value,
            "specific force": sensor.force.value - sensor.force.value.mean(axis=0),
        }
        values = {name: np.broadcast_to(np.linalg.norm(x, axis=1), time.shape) for name, x in size.items()}
        if model.rig.hinge:
            angle, rate = (moment.track(HINGE, order).value[:, 0] for order in range(2))
            values["hinge angle"] = np.abs(angle - np.median(angle))
            values["hinge reversals"] = reversals(time, rate)
        out[imu.name] = Regressors(time, values)
    return out


def reversals(time: Array, rate: Array) -> Array:
    """Return bumps (n,) of height 1 where a rate (n,) changes its sign, without small wavering."""
    least = LOCALIZE.moving * float(np.sqrt(np.mean(rate**2)))
    moving = np.flatnonzero(np.abs(rate) > least)
    turned = np.flatnonzero(rate[moving[1:]] * rate[moving[:-1]] < 0)
    at = 0.5 * (time[moving[turned]] + time[moving[turned + 1]])
    if not len(at):
        return np.zeros_like(time)
    near = np.searchsorted(0.5 * (at[1:] + at[:-1]), time)
    return np.exp(-0.5 * ((time - at[near]) / LOCALIZE.reversal_s) ** 2)
