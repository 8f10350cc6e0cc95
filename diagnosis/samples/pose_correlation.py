"""Measured poses whose errors last: taken as independent, hundreds a second would outweigh every IMU.

An optical record is smoothed by its maker, and often given more densely than it was measured. Its samples then agree
with one another to micrometres, and are a tenth of a millimetre wrong. Beside a gyroscope this shows: between samples
i and i + k the pose turns by conj(q_i) q_(i + k), the gyroscope's integral by c, and::

    e_k = log(conj(c) conj(q_i) q_(i + k)) = r_(i + k) - r_i,  less what is linear in log(c), in the change of the rate
                                                               and of its slope, and constant: mount, scale, clock,
                                                               smoothing and bias

For independent errors r the RMS of e_k, less the gyroscope's declared noise, is the same for every k; it grows with k
while they last. Samples that are closer than that count once.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from imubench.arrays import Array
from imubench.jets import Jet
from imubench.recording import OWN_IMUS, Imu, Pose, Recording
from imubench.rotations import conjugate, exp, log, multiply
from imubench.slope import slope_of

POSE_ERRORS_LAST = 1.1  # times as large half a second apart as where they were taken to be independent: they are not
POSE_ERRORS_GROW = 1.2  # times as large at twice the distance: the errors last
POSE_SPACING_S = 0.06  # s between the samples that count, at most
POSE_FAR_FROM_DECLARED = 1.5  # times a declared noise, from which it is not what is there
POSE_ERRORS_SMOOTH = (
    1.5  # times as large at twice the distance: they change smoothly; steps that are independent grow by 1.41
)
POSE_LASTING_S = 0.5  # s, over which it is seen whether errors that last end
POSE_DECAY_PER_S = (0.5, 50.0)  # per s
POSE_MATCHED_S = 0.015  # s of turning from which mount, scale, clock and bias are read
POSE_PAIRS = 200  # pairs of samples to tell by


@dataclass(frozen=True)
class GaussMarkov:
    """How a measured pose's errors last."""

    rate: float  # a, per s
    step: float  # s between the samples that count

    @property
    def scale(self) -> float:
        """By what r' + a r is multiplied, in s, so that its standard deviation is that of r."""
        return float(np.sqrt(self.step / (2 * self.rate)))

    def whitened(self, error: Jet, change: Jet) -> Jet:
        """Return a row of r and r' (n, 3)."""
        return (change + self.rate * error) * self.scale


def correlated_poses(recording: Recording) -> tuple[dict[str, NDArray[np.bool_]], dict[str, GaussMarkov]]:
    """Return which samples (n,) of every measured pose count whose errors last, and of those that wander how."""
    imus = {recording.carrier(imu.name): imu for imu in recording.imus}
    first = recording.carrier((recording.tree.imus or OWN_IMUS)[0])  # whose pose is what the splines describe
    masks: dict[str, NDArray[np.bool_]] = {}
    wander: dict[str, GaussMarkov] = {}
    for i, pose in enumerate(recording.poses):
        imu = imus.get(pose.segment)
        every, how = apart(pose, imu, pose.segment == first) if imu is not None else (1, None)
        if every > 1:
            counts = np.arange(pose.time.size) % every == 0
            masks |= {f"pose{i + 1}.{part}": counts for part in ("position", "rotation")}
        if how is not None:
            wander[f"pose{i + 1}"] = how
    return masks, wander


def apart(pose: Pose, imu: Imu, may_wander: bool) -> tuple[int, GaussMarkov | None]:
    """Return how many samples apart the errors of a pose count, and how they wander, where they may."""
    step = float(np.median(np.diff(pose.time)))
    spans, k = errors(pose, imu, POSE_LASTING_S), 1
    told = pose.rotation_noise_std
    if told and spans and spans[0] < POSE_FAR_FROM_DECLARED * told and spans[0] > told / POSE_FAR_FROM_DECLARED:
        return 1, None
    for i, (now, later) in enumerate(pairwise(spans)):
        if later > POSE_ERRORS_GROW * now and 2 ** (i + 1) * step <= POSE_SPACING_S:
            k = 2 ** (i + 1)
        elif i:  # between the nearest two lies what samples were resampled by, too
            break
    return (k, None) if k == 1 or not may_wander else wandering(spans, step, k)


def wandering(spans: list[float], step: float, k: int) -> tuple[int, GaussMarkov | None]:
    """Return how many samples apart the changes of errors are independent, and how they wander; else `k` and none.

    `spans` as from `errors`, the samples `step` s apart. They wander where they still grow from k samples on.
    """
    at = k.bit_length() - 1
    if spans[-1] <= POSE_ERRORS_LAST * spans[at]:
        return k, None
    quick = [i for i, (now, later) in enumerate(pairwise(spans[: at + 1])) if later > POSE_ERRORS_SMOOTH * now]
    first = quick[-1] + 1 if quick else 0
    lags, power = step * 2.0 ** np.arange(first, len(spans)), 2 * np.log(spans[first:])
    rates = np.geomspace(*POSE_DECAY_PER_S, 200)
    off = np.array([np.var(power - np.log(-np.expm1(-a * lags))) for a in rates])
    return 2**first, GaussMarkov(float(rates[np.argmin(off)]), step * 2**first)


def errors(pose: Pose, imu: Imu, longest: float) -> list[float]:
    """Return the RMS of r in rad as if independent, from samples 1, 2, 4 and so on apart, up to `longest` s."""
    inside = (pose.time >= imu.time[0]) & (pose.time <= imu.time[-1])
    if pose.quaternion is None or inside.sum() < POSE_PAIRS:
        return []
    time, q = pose.time[inside], pose.quaternion[inside]
    rate = CubicSpline(imu.time, imu.gyro)
    step, noise = float(np.median(np.diff(time))), imu.gyro_noise_std or 0.0
    steps, faster = np.diff(rate.antiderivative()(time), axis=0), np.diff(rate(time), axis=0)
    bending = CubicSpline(imu.time, slope_of(imu.gyro, float(imu.rate)))(time)
    k = max(round(POSE_MATCHED_S / step), 1)
    turned = over(exp(steps), k)
    error = between(turned, q, k)
    good = np.isfinite(error).all(axis=1)
    if good.sum() < POSE_PAIRS:
        return []
    quicker = np.cumsum(np.vstack([np.zeros(3), faster]), axis=0)
    known = np.column_stack([log(turned), quicker[k:] - quicker[:-k], bending[k:] - bending[:-k], np.ones(len(error))])
    law = np.linalg.lstsq(known[good], error[good], rcond=None)[0]
    turned = exp(steps + np.column_stack([steps, faster, np.diff(bending, axis=0), np.full(len(steps), 1 / k)]) @ law)
    out: list[float] = []
    k = 1
    while k * step <= longest and len(turned) >= POSE_PAIRS:
        error = between(turned, q, k)
        good = np.isfinite(error).all(axis=1)
        if good.sum() < POSE_PAIRS:
            break
        known = np.column_stack([log(turned), np.ones(len(error))])[good]
        error = error[good]
        error = error - known @ np.linalg.lstsq(known, error, rcond=None)[0]
        of_gyro = noise**2 * k * step / float(imu.rate)
        out.append(float(np.sqrt(max(float(np.mean(error**2)) - of_gyro, 0.0) / 2)))
        turned, k = multiply(turned[:-k], turned[k:]), 2 * k
    return out


def over(turned: Array, k: int) -> Array:
    """Return the turns (n - k + 1, 4) over k steps of turns over one (n, 4)."""
    out = turned[: len(turned) - k + 1]
    for j in range(1, k):
        out = multiply(out, turned[j : len(turned) - k + 1 + j])
    return out


def between(turned: Array, q: Array, k: int) -> Array:
    """Return what attitudes (n + k, 4) turn in k samples less turns (n, 4), in rad; NaN where unseen."""
    return log(multiply(conjugate(turned), multiply(conjugate(q[:-k]), q[k:])))


__all__ = ["GaussMarkov", "correlated_poses"]
