"""How far an estimate is from the truth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.rotations import angle_between
from imubench.truth import Truth


@dataclass(frozen=True)
class Score:
    """Named figures with their units, one dictionary each for one estimate."""

    estimator: str
    quantity: str
    figures: dict[str, float]
    units: dict[str, str]


def axis_deviation(estimated: ArrayLike, true: ArrayLike) -> Array:
    """Return the angular deviations (..., 2) in rad of a pair of joint axes (..., 2, 3).

    The signs of both axes are turned together so that the first deviates by at most 90 deg;
    the second may then deviate by up to 180 deg, which is a wrong sign pairing
    (Olsson 2020, text below eq. 71).
    """
    est, ref = np.asarray(estimated, dtype=float), np.asarray(true, dtype=float)
    flip = np.sum(est[..., 0, :] * ref[..., 0, :], axis=-1) < 0
    return angle_between(np.where(flip[..., None, None], -est, est), ref)


def rmsae(deviations: ArrayLike) -> float:
    """Return the root mean square of angular deviations of any shape (Olsson 2020, eq. 71)."""
    return float(np.sqrt(np.mean(np.square(np.asarray(deviations, dtype=float)))))


def maxae(deviations: ArrayLike) -> float:
    """Return the largest angular deviation (Olsson 2020, eq. 72)."""
    return float(np.max(np.asarray(deviations, dtype=float)))


def vector_error(estimated: ArrayLike, true: ArrayLike) -> tuple[Array, Array, Array]:
    """Return |dr| and d|r| in m and the deviation angle in rad of vectors (..., 3).

    d|r| is the absolute difference of the norms (Garcia de Villa et al., section IV-B).
    """
    est, ref = np.asarray(estimated, dtype=float), np.asarray(true, dtype=float)
    length = np.abs(np.linalg.norm(est, axis=-1) - np.linalg.norm(ref, axis=-1))
    return np.linalg.norm(est - ref, axis=-1), length, angle_between(est, ref)


def score(estimate: Estimate, truth: Truth) -> Score:
    """Judge an estimate by the truth, at its own sample times or by the time-averaged truth."""
    if estimate.quantity == "joint_axis":
        if estimate.value.shape[0] != 2 or any(s.joint_axis is None for s in truth.sensors):
            raise InputError(f"{estimate.estimator}: expected a rig with a hinge and two IMUs, got rig {truth.rig}")
        axes = np.stack([s.joint_axis.mean(axis=0) for s in truth.sensors if s.joint_axis is not None])
        axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
        deviations = axis_deviation(estimate.value, axes)
        figures = {f"deviation_{s.name}": float(d) for s, d in zip(truth.sensors, deviations, strict=True)}
        figures |= {"rmsae": rmsae(deviations), "maxae": maxae(deviations)}
        return Score(estimate.estimator, estimate.quantity, figures, dict.fromkeys(figures, "rad"))
    figures, units = {}, {}
    for i, sensor in enumerate(truth.sensors):
        if estimate.time is None:
            ref = sensor.joint_vector.mean(axis=0)
        else:
            ref = np.stack([np.interp(estimate.time, truth.time, c) for c in sensor.joint_vector.T], axis=-1)
        names = ("error", "length_error", "angle_error")
        for what, unit, errors in zip(
            names, ("m", "m", "rad"), vector_error(estimate.value[..., i, :], ref), strict=True
        ):
            figures[f"{what}_{sensor.name}"] = float(np.mean(errors))
            units[f"{what}_{sensor.name}"] = unit
    return Score(estimate.estimator, estimate.quantity, figures, units)
