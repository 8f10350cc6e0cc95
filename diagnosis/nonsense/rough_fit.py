"""How badly the seconds of most motion go with the declared rig: what tells two readings of a recording apart."""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.nonsense import STRETCH
from imubench.diagnosis.noise.nominal import first_fit
from imubench.diagnosis.nonsense.stretch import grid, gridded, stretch_of_most_motion
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.initialize import model_of
from imubench.recording import Imu, Pose, Recording


def rough_misfit(recording: Recording) -> float:
    """Return the RMS residual of the first fit, over its loose noise (0.3 rad/s, 1 m/s^2); inf where there is no fit.

    0.1 to 0.2 for a recording that goes with its rig, 0.3 beside strong effects, up to 1.7 on real foam.
    """
    some = thinned(stretch_of_most_motion(recording, STRETCH.rough_s))
    try:
        fit = first_fit(model_of(some), STRETCH.rough_steps)
    except (NotPositiveDefiniteError, np.linalg.LinAlgError):
        return np.inf
    count = sum(r.residual.value.size for r in fit.measured)
    cost = sum(r.cost for r in fit.rows)
    return float(np.sqrt(2 * cost / count)) if np.isfinite(cost) else np.inf


def thinned(recording: Recording) -> Recording:
    """Return a recording with its sensors at no more than `STRETCH.grid_hz`."""
    poses = tuple(_pose(p) for p in recording.poses)
    return replace(recording, imus=tuple(_imu(i) for i in recording.imus), poses=poses)


def _imu(imu: Imu) -> Imu:
    edges = grid([imu.time])
    if len(edges) < 3 or edges[1] - edges[0] < 1.5 * float(np.median(np.diff(imu.time))):
        return imu
    some = gridded(imu, edges)
    return replace(imu, time=some.time, gyro=some.gyro, accel=some.accel, rate=1 / some.step)


def _pose(pose: Pose) -> Pose:
    every = max(1, round(1 / (STRETCH.grid_hz * float(np.median(np.diff(pose.time))))))
    position, quaternion = (None if x is None else x[::every] for x in (pose.position, pose.quaternion))
    return replace(pose, time=pose.time[::every], position=position, quaternion=quaternion)


def mounts_known(recording: Recording) -> bool:
    """Return whether all mounts are declared well enough to tell orders of axes apart."""
    stds = [imu.mount_rotation_std for imu in recording.imus]
    return all(std is not None and std <= STRETCH.known_mount_rad for std in stds)


__all__ = ["mounts_known", "rough_misfit"]
