"""How far an estimate is from the truth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array
from imubench.callable_module import call_as
from imubench.displays import Displayed
from imubench.errors import InputError
from imubench.estimate import Estimate, Pairing
from imubench.rotations import angle_between
from imubench.truth import Truth

BEST_PAIRING = "best_pairing_"
"""In front of a figure of axes whose sign pairing is unknown: that of the better pairing, which nobody has claimed."""


@dataclass(frozen=True)
class Score(Displayed):
    """Named figures with their units, one dictionary each for one estimate."""

    estimator: str
    quantity: str
    figures: dict[str, float]
    units: dict[str, str]
    pairing: Pairing | None = None  # of the estimate: what its signs are worth

    def deviation(self, imu: str) -> float | None:
        """Return the angle in rad by which the axis of an IMU is off, of the better pairing if that is unknown."""
        name = f"deviation_{imu}"
        return self.figures.get(name, self.figures.get(f"{BEST_PAIRING}{name}"))


def axis_deviation(estimated: ArrayLike, true: ArrayLike) -> Array:
    """Return the angular deviations (..., 2) in rad of a pair of joint axes (..., 2, 3).

    The signs of both axes are turned together so that the first deviates by at most 90 deg;
    the second may then deviate by up to 180 deg, which is a wrong sign pairing
    (Olsson 2020, text below eq. 71).
    """
    est, ref = np.asarray(estimated, dtype=float), np.asarray(true, dtype=float)
    flip = np.sum(est[..., 0, :] * ref[..., 0, :], axis=-1) < 0
    return angle_between(np.where(flip[..., None, None], -est, est), ref)


def line_deviation(estimated: ArrayLike, true: ArrayLike) -> Array:
    """Return the angular deviations (...) in rad, at most pi / 2, of axes (..., 3) whose signs mean nothing."""
    angle = angle_between(estimated, true)
    return np.asarray(np.minimum(angle, np.pi - angle))


def axis_score(estimate: Estimate, axes: ArrayLike, imus: Sequence[str]) -> Score:
    """Return how far estimated axes are from others, (2, 3), in the same sensor axes, by the names of the IMUs.

    Where the sign pairing is unknown, figures are those of the better pairing and named `best_pairing_...`.
    """
    known = estimate.pairing != "unknown"
    deviations = axis_deviation(estimate.value, axes) if known else line_deviation(estimate.value, axes)
    prefix = "" if known else BEST_PAIRING
    figures = {f"{prefix}deviation_{name}": float(d) for name, d in zip(imus, deviations, strict=True)}
    return Score(estimate.estimator, estimate.quantity, figures, dict.fromkeys(figures, "rad"), estimate.pairing)


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
    """Judge an estimate by the truth, at its own sample times or by the time-averaged truth.

    Axes whose sign pairing is unknown are judged by the better one, and the figures say so in their names.
    """
    if estimate.quantity == "joint_axis":
        if estimate.value.shape[0] != 2 or any(s.joint_axis is None for s in truth.sensors):
            raise InputError(f"{estimate.estimator}: expected a rig with a hinge and two IMUs, got rig {truth.rig}")
        axes = np.stack([s.joint_axis.mean(axis=0) for s in truth.sensors if s.joint_axis is not None])
        axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
        judged = axis_score(estimate, axes, [s.name for s in truth.sensors])
        deviations = list(judged.figures.values())
        prefix = BEST_PAIRING if estimate.pairing == "unknown" else ""
        figures = judged.figures | {f"{prefix}rmsae": rmsae(deviations), f"{prefix}maxae": maxae(deviations)}
        return replace(judged, figures=figures, units=dict.fromkeys(figures, "rad"))
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


call_as(__name__, __name__, "score")
