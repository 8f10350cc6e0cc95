"""Recordings, truths, estimates, scores and diagnoses as tables of pandas."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from imubench.diagnosis.result import Diagnosis
from imubench.displays.displayed import missing
from imubench.estimate import Estimate
from imubench.recording import Recording
from imubench.score import Score
from imubench.truth import Truth

if TYPE_CHECKING:
    import pandas

XYZ = "xyz"
SEGMENT = ("position", "quaternion", "velocity", "rate", "acceleration", "angular_acceleration")
SENSOR = (
    "position", "quaternion", "acceleration", "gyro", "specific_force", "angular_acceleration", "joint_vector",
    "joint_axis", "displacement", "rotation",
)  # fmt: skip


def frame(value: Any) -> pandas.DataFrame:
    """Return a value as a table; `InputError` without pandas."""
    try:
        import pandas
    except ImportError:
        raise missing("pandas", "pandas", "to_pandas") from None
    return pandas.DataFrame(COLUMNS[type(value)](value))


def _recording(r: Recording) -> Mapping[str, Any]:
    """A row a sample, one IMU below the other: each has a clock of its own."""
    columns: dict[str, Any] = {"imu": np.repeat([i.name for i in r.imus], [i.time.size for i in r.imus])}
    columns["time"] = np.concatenate([i.time for i in r.imus]) if r.imus else []
    for key, short in (("gyro", "gyr"), ("accel", "acc")):
        values = np.concatenate([getattr(i, key) for i in r.imus]) if r.imus else np.empty((0, 3))
        columns |= {f"{short}_{axis}": values[:, k] for k, axis in enumerate(XYZ)}
    return columns


def _truth(t: Truth) -> Mapping[str, Any]:
    """A row a sample, the columns named as in a dataset's table of samples."""
    columns: dict[str, Any] = {"time": t.time}
    if t.joint_angle is not None:
        columns |= {"hinge_angle": t.joint_angle, "hinge_rate": t.joint_rate}
    for segment in t.segments:
        columns |= dict(_components(segment, segment.name, SEGMENT))
    for sensor in t.sensors:
        columns |= dict(_components(sensor, f"{sensor.name}_true", SENSOR))
    return columns


def _components(part: Any, prefix: str, keys: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
    for key in keys:
        values = getattr(part, key)
        if values is not None:
            names = XYZ if values.shape[1] == 3 else "wxyz"
            yield from ((f"{prefix}_{key}_{name}", values[:, k]) for k, name in enumerate(names))


def _estimate(e: Estimate) -> Mapping[str, Any]:
    """A row for each IMU, of a stream for each IMU and time; standard deviations where there is a covariance."""
    value = e.value.reshape(-1, *e.value.shape[-2:])
    count, imus, _ = value.shape
    columns: dict[str, Any] = {} if e.time is None else {"time": np.repeat(e.time, imus)}
    columns["imu"] = [f"imu{i + 1}" for i in range(imus)] * count
    columns |= {axis: value[..., k].ravel() for k, axis in enumerate(XYZ)}
    if e.covariance is not None:
        variance = np.diagonal(e.covariance, axis1=-2, axis2=-1).reshape(count, imus, 3)
        std = np.sqrt(np.maximum(variance, 0.0))
        columns |= {f"std_{axis}": std[..., k].ravel() for k, axis in enumerate(XYZ)}
    return columns


def _score(s: Score) -> Mapping[str, Any]:
    """A row a figure."""
    names = list(s.figures)
    return {"figure": names, "value": [s.figures[n] for n in names], "unit": [s.units[n] for n in names]}


def _diagnosis(d: Diagnosis) -> Mapping[str, Any]:
    """A row for each number of each finding; a finding without numbers has one row."""
    keys = ("effect", "at", "confidence", "material", "share", "parameter", "component", "value", "std", "unit")
    rows: list[tuple[Any, ...]] = []
    for f in d.findings:
        whole = (f.effect, f.at, f.confidence, f.material, f.share)
        for name, p in f.parameters.items():
            values, stds = np.ravel(p.value), np.ravel(np.broadcast_to(p.std, np.shape(p.value)))
            pairs = enumerate(zip(values, stds, strict=True))
            rows += [(*whole, name, k, float(value), float(std), p.unit) for k, (value, std) in pairs]
        if not f.parameters:
            rows.append((*whole, None, None, None, None, None))
    return {key: [row[k] for row in rows] for k, key in enumerate(keys)}


COLUMNS: dict[type, Callable[[Any], Mapping[str, Any]]] = {
    Recording: _recording,
    Truth: _truth,
    Estimate: _estimate,
    Score: _score,
    Diagnosis: _diagnosis,
}
"""The columns of each type's table."""
