"""Estimates and scores as JSON, with the unit beside every figure."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.estimate import Estimate, Failed
from imubench.estimators import ESTIMATORS
from imubench.recording import Recording
from imubench.reference_axes import HINGE_AXIS
from imubench.score import Score, axis_score, line_deviation, vector_error

UNITS = {"joint_axis": "1", "joint_vector": "m"}


def estimate_as_dict(estimate: Estimate) -> dict[str, Any]:
    """Return an estimate as plain numbers and text."""
    answer: dict[str, Any] = {
        "estimator": estimate.estimator,
        "quantity": estimate.quantity,
        "unit": UNITS[estimate.quantity],
        "status": estimate.status,
        "value": estimate.value.tolist(),
        "covariance": None if estimate.covariance is None else estimate.covariance.tolist(),
        "details": {key: float(value) for key, value in estimate.details.items()},
    }
    if estimate.quantity == "joint_axis":
        answer["pairing"] = estimate.pairing
    if estimate.covariance is None:
        answer["no_covariance_because"] = estimate.no_covariance_because
    if estimate.time is not None:
        answer["time"] = estimate.time.tolist()
    return answer


def failure_as_dict(failed: Failed) -> dict[str, Any]:
    """Return why there is no estimate as plain text."""
    return {"estimator": failed.estimator, "status": failed.status, "why": failed.why}


def score_as_dict(score: Score) -> dict[str, Any]:
    """Return a score as figures with their units."""
    figures = {k: {"value": v, "unit": score.units[k]} for k, v in score.figures.items()}
    content = {"estimator": score.estimator, "quantity": score.quantity, "figures": figures}
    return content | ({"pairing": score.pairing} if score.quantity == "joint_axis" else {})


def pairing_note(estimate: Estimate, recording: Recording) -> str:
    """Return a line about what says how the signs of two axes go together; empty for other quantities."""
    if estimate.quantity != "joint_axis" or estimate.status == "not identifiable":
        return ""
    if estimate.pairing is None:
        return "sign pairing not said by the estimator: taken as claimed"
    if estimate.pairing != "unknown":
        return f"sign pairing {estimate.pairing}"
    if declared_axes(recording) is None:
        return "sign pairing unknown: no declared mounts"
    if estimate.estimator not in ESTIMATORS:  # which may have no use for them
        return "sign pairing unknown, the estimator says: figures are of the better of both pairings"
    return "sign pairing unknown: the declared mounts do not tell it"


def moved(before: Estimate, after: Estimate) -> tuple[Array, str] | None:
    """Return by how much two estimates by one estimator differ.

    Args:
        before: the one.
        after: the other; of as many IMUs.

    Returns:
        A number for each IMU (m,), and its unit. Of axes the angle between the lines in deg, for their signs are one
        choice for all; of vectors the distance in mm, where there is one a sample its RMS over the stamps that both
        have. None where there are none.
    """
    if before.quantity == "joint_axis":
        return np.degrees(line_deviation(after.value, before.value)), "deg"
    one, other = before.value, after.value
    if before.time is not None and after.time is not None:
        _, i, j = np.intersect1d(before.time, after.time, return_indices=True)
        one, other = one[i], other[j]
    squares = np.sum((one - other) ** 2, axis=-1).reshape(-1, one.shape[-2])
    return (1e3 * np.sqrt(np.mean(squares, axis=0)), "mm") if len(squares) else None


def declared_axes(recording: Recording) -> Array | None:
    """Return the hinge axis (2, 3) in each sensor frame by the declared mounts; None without two of known rotation."""
    if recording.tree.hinge is None or len(recording.imus) != 2:
        return None
    if any(imu.mount_rotation_std is None for imu in recording.imus):
        return None
    return np.stack([rotations.rotate_back(imu.mount_quaternion, HINGE_AXIS) for imu in recording.imus])


def beside_axes(estimate: Estimate, recording: Recording, axes: Array | None) -> Score | None:
    """Return how far estimated hinge axes (2, 3) are from others in the same sensor axes, or None without any.

    This is no score: a declared mount is a belief, and a reference has errors of its own.
    """
    if estimate.quantity != "joint_axis" or axes is None:
        return None
    return axis_score(estimate, axes, [imu.name for imu in recording.imus])


def beside_declared_vector(estimate: Estimate, recording: Recording) -> Score | None:
    """Return how far estimated IMU-to-joint vectors are from those of the declared mounts, or None without any."""
    if estimate.quantity != "joint_vector" or any(imu.mount_position_std is None for imu in recording.imus):
        return None
    figures = {}
    for i, imu in enumerate(recording.imus):
        r = rotations.rotate_back(imu.mount_quaternion, -imu.mount_position)
        figures[f"error_{imu.name}"] = float(np.mean(vector_error(estimate.value[..., i, :], r)[0]))
    return Score(estimate.estimator, estimate.quantity, figures, dict.fromkeys(figures, "m"))


def write_json(path: Path, content: object) -> None:
    """Write JSON that every parser reads: finite numbers only."""
    path.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")
