"""The hinge axis in sensor axes as an independent reference saw it."""

import numpy as np
from scipy.spatial.transform import Rotation

from imubench import rotations
from imubench.arrays import Array
from imubench.recording import Imu, Recording
from imubench.reference import Reference

HINGE_AXIS = np.array([0.0, 1.0, 0.0])
FEWEST = 50  # reference samples that must be seen, turning, before an alignment means anything
SLOWEST = 0.2  # rad/s, RMS, about the second most excited direction


def reference_axes(recording: Recording, reference: Reference | None) -> Array | None:
    """Return the hinge axes (2, 3) in sensor axes, or None where the reference cannot tell.

    Each sensor's rotation against its segment is the one that best turns the reference's angular
    rate into the gyroscope's (Wahba's problem); the axis is +y of the segment. None without both
    orientations, with fewer than 50 usable samples, or where a segment turned about one direction only.
    """
    if reference is None or recording.tree.hinge is None or len(recording.imus) != 2:
        return None
    axes = []
    for imu, q in zip(recording.imus, (reference.quaternion1, reference.quaternion2), strict=True):
        mount = None if q is None else _mount_rotation(imu, reference.time, q)
        if mount is None:
            return None
        axes.append(mount.inv().apply(HINGE_AXIS))
    return np.stack(axes)


def _mount_rotation(imu: Imu, time: Array, q: Array) -> Rotation | None:
    """Return the rotation sensor -> segment, or None."""
    span = time[2:] - time[:-2]
    turned = rotations.log(rotations.multiply(rotations.conjugate(q[:-2]), q[2:]))
    middle = rotations.multiply(q[:-2], rotations.exp(turned / 2))
    rate_w = rotations.rotate(q[:-2], turned) / span[:, None]
    rate_b = rotations.rotate_back(middle, rate_w)
    travelled = np.concatenate([np.zeros((1, 3)), np.cumsum(_steps(imu), axis=0)])  # integral of the gyro, for averages
    at = [np.stack([np.interp(t, imu.time, c) for c in travelled.T], axis=-1) for t in (time[:-2], time[2:])]
    rate_s = (at[1] - at[0]) / span[:, None]
    inside = (time[:-2] >= imu.time[0]) & (time[2:] <= imu.time[-1]) & (span < 4 * np.median(np.diff(time)))
    good = inside & np.isfinite(rate_b).all(axis=1)
    if good.sum() < FEWEST or np.linalg.svd(rate_b[good], compute_uv=False)[1] < SLOWEST * np.sqrt(good.sum()):
        return None
    return Rotation.align_vectors(rate_b[good], rate_s[good])[0]


def _steps(imu: Imu) -> Array:
    return (imu.gyro[1:] + imu.gyro[:-1]) / 2 * np.diff(imu.time)[:, None]
