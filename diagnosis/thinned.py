"""Measured poses whose errors last: taken as independent, hundreds a second would outweigh every IMU.

An optical record is smoothed by its maker, and often given more densely than it was measured. Its samples then agree
with one another to micrometres, and are a tenth of a millimetre wrong. Beside a gyroscope this shows: between samples
i and i + k the pose turns by conj(q_i) q_(i + k), the gyroscope's integral by c, and::

    e_k = log(conj(c) conj(q_i) q_(i + k)) = r_(i + k) - r_i,  less what is linear in log(c), in the change of the rate,
                                                               and constant: mount, scale, clock and bias

For independent errors r the RMS of e_k, less the gyroscope's declared noise, is the same for every k; it grows with k
while they last. Samples that are closer than that count once.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from imubench.arrays import Array
from imubench.recording import Imu, Pose, Recording
from imubench.rotations import conjugate, exp, log, multiply

GROWS = 1.2  # times as large at twice the distance: the errors last
LONGEST = 0.06  # s between the samples that count, at most
DECLARED = 1.5  # times a declared noise, from which it is not what is there
FEWEST = 200  # pairs of samples to tell by


def pose_masks(recording: Recording) -> dict[str, NDArray[np.bool_]]:
    """Return which samples (n,) of every measured pose count, for those whose errors last."""
    imus = {f"segment{imu.name[-1]}": imu for imu in recording.imus}
    masks: dict[str, NDArray[np.bool_]] = {}
    for i, pose in enumerate(recording.poses):
        imu = imus.get(pose.segment)
        every = apart(pose, imu) if imu is not None else 1
        if every > 1:
            counts = np.arange(pose.time.size) % every == 0
            masks |= {f"pose{i + 1}.{part}": counts for part in ("position", "rotation")}
    return masks


def apart(pose: Pose, imu: Imu) -> int:
    """Return how many samples apart the errors of a pose are independent, beside the gyroscope on its segment."""
    step = float(np.median(np.diff(pose.time)))
    spans, k = errors(pose, imu, LONGEST), 1
    told = pose.rotation_noise_std
    if told and spans and spans[0] < DECLARED * told and spans[0] > told / DECLARED:
        return 1
    for now, later in pairwise(spans):
        if later <= GROWS * now or 2 * k * step > LONGEST:
            break
        k *= 2
    return k


def errors(pose: Pose, imu: Imu, longest: float) -> list[float]:
    """Return the RMS of r in rad, were it independent, from samples 1, 2, 4 and so on apart, up to `longest` s."""
    inside = (pose.time >= imu.time[0]) & (pose.time <= imu.time[-1])
    if pose.quaternion is None or inside.sum() < FEWEST:
        return []
    time, q = pose.time[inside], pose.quaternion[inside]
    rate = CubicSpline(imu.time, imu.gyro)
    turned = exp(np.diff(rate.antiderivative()(time), axis=0))
    w, step, noise = rate(time), float(np.median(np.diff(time))), imu.gyro_noise_std or 0.0
    out: list[float] = []
    k = 1
    while k * step <= longest and len(turned) >= FEWEST:
        pairs = np.isfinite(q[:-k]).all(axis=1) & np.isfinite(q[k:]).all(axis=1)
        if pairs.sum() < FEWEST:
            break
        between, c = multiply(conjugate(q[:-k][pairs]), q[k:][pairs]), turned[pairs]
        left = unexplained(log(multiply(conjugate(c), between)), log(c), (w[k:] - w[:-k])[pairs])
        of_gyro = noise**2 * k * step / float(imu.rate)
        out.append(float(np.sqrt(max(float(np.mean(left**2)) - of_gyro, 0.0) / 2)))
        turned, k = multiply(turned[:-k], turned[k:]), 2 * k
    return out


def unexplained(error: Array, turned: Array, faster: Array) -> Array:
    """Return what mount, scale, clock and bias leave of errors (n, 3), by least squares."""
    known = np.column_stack([turned, faster, np.ones(len(error))])
    return np.asarray(error - known @ np.linalg.lstsq(known, error, rcond=None)[0])


__all__ = ["pose_masks"]
