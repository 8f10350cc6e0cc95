"""The joint as each IMU sees it, in Rerun: true and estimated axes, and vectors to its centre."""

from dataclasses import dataclass

import numpy as np
import rerun as rr

from imubench.arrays import Array
from imubench.estimate import Estimate
from imubench.log.signals import ESTIMATED, TRUE, drawn_rows, time_column
from imubench.recording import Recording
from imubench.truth import Truth

LENGTH = {"true": (0.28, 0.28), "estimated": (0.1, 0.19)}  # m, of the axis of each IMU: unequal, to tell them apart
RADIUS = {"true": 0.005, "estimated": 0.008}  # m
LABEL_AT = {("true", "axis"): 1.0, ("estimated", "axis"): 1.0, ("true", "vector"): 0.4, ("estimated", "vector"): 0.8}
COLOUR = {"true": TRUE, "estimated": ESTIMATED}


@dataclass(frozen=True)
class Arrow:
    """An arrow in a sensor's frame; one row: it does not move there."""

    kind: str  # true | estimated
    quantity: str  # axis | vector
    label: str
    time: Array  # (n,) s
    origin: Array  # (n, 3) m
    vector: Array  # (n, 3) m


def mean_axes(recording: Recording, truth: Truth | None) -> Array | None:
    """Return the true joint axes (m, 3) in sensor axes, averaged over time; None without a hinge or a truth."""
    if truth is None:
        return None
    axes = [truth.sensor(imu.name).joint_axis for imu in recording.imus]
    means = [a.mean(axis=0) for a in axes if a is not None]
    if not means or len(means) < len(axes):
        return None
    return np.stack([m / np.linalg.norm(m) for m in means])


def joint_arrows(
    i: int,
    name: str,
    centre: Array,
    truth: Truth | None,
    estimate: Estimate | None,
    true_axes: Array | None,
    judge: str,
) -> list[Arrow]:
    """Return the arrows of the i-th IMU, `name`, in its frame; `centre` (3,) m is where the joint is drawn,
    `judge` the word for what is true.

    An axis starts at the joint centre, a vector r at the sensor.
    """
    start, origin = np.zeros(1), centre[None]
    arrows = []
    true_label = f"{judge} axis" if i == 0 else ""  # both coincide
    vector_wanted = estimate is not None and estimate.quantity == "joint_vector"
    if truth is not None:
        sensor, rows = truth.sensor(name), drawn_rows(truth.time)
        time, r = truth.time[rows], sensor.joint_vector[rows]
        start, origin = time[:1], r.mean(axis=0, keepdims=True)
        if vector_wanted:
            arrows.append(Arrow("true", "vector", f"true r {name}", time, np.zeros_like(r), r))
        elif sensor.joint_axis is not None:
            arrows.append(Arrow("true", "axis", true_label, time, r, LENGTH["true"][i] * sensor.joint_axis[rows]))
    elif true_axes is not None:
        arrows.append(Arrow("true", "axis", true_label, start, origin, LENGTH["true"][i] * true_axes[i : i + 1]))
    if estimate is None or i >= estimate.value.shape[-2]:
        return arrows
    if not vector_wanted:
        vector = LENGTH["estimated"][i] * estimate.value[i : i + 1]
        return [*arrows, Arrow("estimated", "axis", f"est. {name}", start, origin, vector)]
    time, vector = start, estimate.value[None, i] if estimate.time is None else estimate.value[:, i]
    if estimate.time is not None:
        rows = drawn_rows(estimate.time)
        time, vector = estimate.time[rows], vector[rows]
    return [*arrows, Arrow("estimated", "vector", f"est. r {name}", time, np.zeros_like(vector), vector)]


def log_arrow(rec: rr.RecordingStream, path: str, arrow: Arrow) -> None:
    """Log an arrow, and its label, under a sensor's path, once if it does not move."""
    colour, radius = [COLOUR[arrow.kind]], [RADIUS[arrow.kind]]
    tip = arrow.origin + LABEL_AT[arrow.kind, arrow.quantity] * arrow.vector
    name = rr.Points3D.from_fields(colors=colour, radii=[0.001], labels=[arrow.label], show_labels=True)
    still = max(np.ptp(arrow.origin, axis=0).max(), np.ptp(arrow.vector, axis=0).max()) < 1e-9  # m: rounding
    if still:
        arrows = rr.Arrows3D(origins=arrow.origin[:1], vectors=arrow.vector[:1], colors=colour, radii=radius)
        rec.log(path, arrows, static=True)
    else:
        rec.log(path, rr.Arrows3D.from_fields(colors=colour, radii=radius), static=True)
        columns = rr.Arrows3D.columns(origins=arrow.origin, vectors=arrow.vector)
        rec.send_columns(path, indexes=[time_column(arrow.time)], columns=columns)
    if not arrow.label:
        return
    rec.log(f"{path}/label", name, static=True)
    if still:
        rec.log(f"{path}/label", rr.Points3D.from_fields(positions=tip[:1]), static=True)
    else:
        times = [time_column(arrow.time)]
        rec.send_columns(f"{path}/label", indexes=times, columns=rr.Points3D.columns(positions=tip))
