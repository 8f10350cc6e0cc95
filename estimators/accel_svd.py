"""The hinge axis from accelerometers alone: Olsson 2020, eq. (51), a singular value decomposition of all samples."""

import numpy as np

from imubench.arrays import Array
from imubench.estimate import Estimate
from imubench.estimators.extent import too_short
from imubench.estimators.hinge_constraints import triangular
from imubench.estimators.pairing import paired_axes
from imubench.paired import paired
from imubench.recording import Recording

NAME = "accel-svd"
UNKNOWNS = 5  # a direction in six dimensions
SEPARATION = 10.0  # of the two smallest squared singular values; noise alone makes them equal


def solve(accel1: Array, accel2: Array) -> tuple[Array, Array, Array]:
    """Return the axes (2, 3), signs paired, and all singular values (6,) and vectors (6, 6) of A, eq. (27) and (47).

    The axes are the halves of w_6, which makes |A w| least of all unit vectors; each half is then normalised.
    That is not the least |A j| under |j1| = |j2| = 1, but the same where A w_6 = 0.
    """
    _, values, vectors = np.linalg.svd(triangular(np.hstack([accel1, -accel2])), full_matrices=False)
    values = np.concatenate([values, np.zeros(6 - values.size)])
    if len(vectors) < 6:
        vectors = np.linalg.svd(vectors)[2]  # complete the basis
    halves = vectors[5].reshape(2, 3)
    lengths = np.linalg.norm(halves, axis=1, keepdims=True)
    return np.where(lengths > 0, halves / np.where(lengths > 0, lengths, 1.0), np.eye(3)[:1]), values, vectors


def estimate(recording: Recording) -> Estimate:
    """Estimate the hinge axis (2, 3) from the accelerometers of all samples; `pairing` says what pairs the signs.

    `not identifiable` where s_5^2 is not ten times s_6^2, so that a second direction fits nearly as well, or where the
    IMUs share too few samples. The covariance is that of white noise, to first order, with the std of what A w_6
    leaves. The common sign points along +y of the segments, by the declared mounts. Raises `InputError` with fewer
    than two IMUs.
    """
    samples = paired(recording)
    axes, values, vectors = solve(samples.accel1, samples.accel2)
    axes, pairing = paired_axes(recording, axes, samples.accel1, samples.accel2)
    count = samples.time.size
    details = {f"singular_value_{i + 1}": float(v) for i, v in enumerate(values)} | {"samples": float(count)}
    why = too_short(samples.time, UNKNOWNS)
    if not why and (values[4] ** 2 <= SEPARATION * values[5] ** 2 or values[4] <= 1e-9 * values[0]):
        why = "there is a second direction in which the accelerations along the axes agree nearly as well"
    if why:
        return Estimate("joint_axis", NAME, axes, None, why, "not identifiable", details=details, pairing="unknown")
    spread = covariance(axes, values, vectors, count)
    return Estimate("joint_axis", NAME, axes, spread, details=details, pairing=pairing)


def covariance(axes: Array, values: Array, vectors: Array, count: int) -> Array:
    """Return the covariance (6, 6) of the axes from that of w_6, the sum of s^2 w_i w_i^T / s_i^2 over i < 6."""
    residual = values[5] ** 2 / max(count - 5, 1)
    of_vector = residual * (vectors[:5].T / values[:5] ** 2) @ vectors[:5]
    turned = np.zeros((6, 6))
    for i, axis in enumerate(axes):
        half = slice(3 * i, 3 * i + 3)
        length = float(axis @ vectors[5, half])  # negative where the axis took the other sign
        turned[half, half] = (np.eye(3) - np.outer(axis, axis)) / length
    return np.asarray(turned @ of_vector @ turned.T)
