"""The columns of the table of samples: signals and truth side by side, one row a sample of the truth's grid.

Row k stands for k / rate s. An IMU's sample stands in the row nearest to its stamp, so a clock that is off shows as
rows that do not belong together, as in a laboratory; rows that an IMU has no sample for are empty. What a rig does not
have (a second IMU, a hinge angle) is empty too, so that all files of a dataset have the same columns.
"""

from collections.abc import Iterator

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.dataset.playing import Made, rows_of
from imubench.dataset.spec import Spec
from imubench.recording import Imu, Pose, Recording
from imubench.truth import SegmentTruth, SensorTruth

XYZ, WXYZ = "xyz", "wxyz"
SIGNALS = (("gyro", "gyr"), ("accel", "acc"))  # field of an Imu, name of its columns
SEGMENT_FIELDS = {  # field of SegmentTruth -> its components
    "position": XYZ, "quaternion": WXYZ, "velocity": XYZ, "rate": XYZ, "acceleration": XYZ, "angular_acceleration": XYZ,
}  # fmt: skip
SHARED_ORIGIN = ("position", "velocity", "acceleration")  # of both segments' frames: kept once, with segment 1
SENSOR_FIELDS = {
    "position": XYZ, "quaternion": WXYZ, "acceleration": XYZ, "gyro": XYZ, "specific_force": XYZ,
    "angular_acceleration": XYZ, "joint_vector": XYZ, "joint_axis": XYZ, "displacement": XYZ, "rotation": XYZ,
}  # fmt: skip
POSE_FIELDS = {"position": XYZ, "quaternion": WXYZ}  # field of a measured Pose -> its components
CORE = ("quaternion", "gyro", "specific_force", "joint_vector", "joint_axis")
"""What `truth = "core"` keeps of segments and sensors, beside the hinge angle."""


def segment_fields(spec: Spec, number: int) -> dict[str, str]:
    """Return the fields that are kept of segment `number`, and their components."""
    left_out = SHARED_ORIGIN if number == 2 else ()
    return {k: c for k, c in SEGMENT_FIELDS.items() if k not in left_out and _kept(spec, k)}


def sensor_fields(spec: Spec) -> dict[str, str]:
    """Return the fields that are kept of a sensor's truth, and their components."""
    return {k: c for k, c in SENSOR_FIELDS.items() if _kept(spec, k)}


def _kept(spec: Spec, key: str) -> bool:
    return spec.truth == "full" or (spec.truth == "core" and key in CORE)


def numbers(spec: Spec) -> list[int]:
    """Return the numbers of IMUs, and of segments, of the spec's largest rig."""
    return list(range(1, spec.sensors + 1))


def schema(spec: Spec) -> pa.Schema:
    """Return names and types of the columns of the table of samples."""
    kind = pa.float32() if spec.precision == "single" else pa.float64()
    columns = [("recording", pa.int32()), ("split", pa.dictionary(pa.int8(), pa.string())), ("time", pa.float64())]
    for n in numbers(spec):
        columns.append((f"imu{n}_time", pa.float64()))
        columns += [(f"imu{n}_{name}_{axis}", kind) for _, name in SIGNALS for axis in XYZ]
    columns += [(name, kind) for name in (*measured_columns(spec), *truth_columns(spec))]
    return pa.schema(columns)


def measured_columns(spec: Spec) -> list[str]:
    """Return the names of the columns of the encoder and of measured poses, of a spec that has them."""
    names = [] if spec.encoder is None else ["encoder_angle"]
    for pose in spec.poses:
        names += [f"{pose.segment}_measured_{key}_{c}" for key, parts in POSE_FIELDS.items() for c in parts]
    return names


def truth_columns(spec: Spec) -> list[str]:
    """Return the names of the truth's columns."""
    if spec.truth == "none":
        return []
    names = ["hinge_angle", "hinge_rate"] if spec.sensors > 1 else []
    for n in numbers(spec):
        names += [f"segment{n}_{key}_{c}" for key, parts in segment_fields(spec, n).items() for c in parts]
    for n in numbers(spec):
        names += [f"imu{n}_true_{key}_{c}" for key, parts in sensor_fields(spec).items() for c in parts]
    return names


def samples_table(spec: Spec, made: Made) -> pa.Table:
    """Return one recording's rows of the table of samples."""
    form = schema(spec)
    count = made.truth.time.size
    arrays: dict[str, pa.Array] = {
        "recording": _column(np.full(count, made.drawn.index), pa.int32()),
        "split": pa.DictionaryArray.from_arrays(
            _column(np.full(count, list(spec.splits).index(made.drawn.split)), pa.int8()), list(spec.splits)
        ),
        "time": _column(made.truth.time, pa.float64()),
    }
    for imu in made.recording.imus:
        arrays |= {n: _spread(values, rows, count, form.field(n).type) for n, values, rows in _signals(imu)}
    pairs = (*_measured(made.recording), *_truth(spec, made))
    arrays |= {name: _column(values, form.field(name).type) for name, values in pairs}
    columns = [arrays.get(field.name, pa.nulls(count, field.type)) for field in form]
    return pa.Table.from_arrays(columns, schema=form)


def _signals(imu: Imu) -> Iterator[tuple[str, Array, NDArray[np.intp]]]:
    """Yield column, values and rows of what an IMU recorded."""
    rows = rows_of(imu.time, imu.rate)
    yield f"{imu.name}_time", imu.time, rows
    for key, name in SIGNALS:
        for i, axis in enumerate(XYZ):
            yield f"{imu.name}_{name}_{axis}", getattr(imu, key)[:, i], rows


def _measured(recording: Recording) -> Iterator[tuple[str, Array]]:
    for encoder in recording.encoders:
        yield "encoder_angle", encoder.angle
    for pose in recording.poses:
        yield from _components(pose, f"{pose.segment}_measured", POSE_FIELDS)


def _spread(values: Array, rows: NDArray[np.intp], count: int, kind: pa.DataType) -> pa.Array:
    """Return `values` in their rows; the other rows are empty."""
    if len(values) == count:
        return _column(values, kind)
    column = np.zeros(count)
    empty = np.ones(count, dtype=bool)
    column[rows], empty[rows] = values, False
    return pa.array(column, type=kind, mask=empty)


def _column(values: Array, kind: pa.DataType) -> pa.Array:
    """Return numbers as a column: `pa.array` without its look at what they are."""
    own = np.ascontiguousarray(values, dtype=kind.to_pandas_dtype())
    return pa.Array.from_buffers(kind, len(own), [None, pa.py_buffer(own)])


def _truth(spec: Spec, made: Made) -> Iterator[tuple[str, Array]]:
    if spec.truth == "none":
        return
    truth = made.truth
    if truth.joint_angle is not None and truth.joint_rate is not None:
        yield "hinge_angle", truth.joint_angle
        yield "hinge_rate", truth.joint_rate
    for n, segment in enumerate(truth.segments, 1):
        yield from _components(segment, f"segment{n}", segment_fields(spec, n))
    for n, sensor in enumerate(truth.sensors, 1):
        yield from _components(sensor, f"imu{n}_true", sensor_fields(spec))


def _components(
    part: SegmentTruth | SensorTruth | Pose, name: str, kept: dict[str, str]
) -> Iterator[tuple[str, Array]]:
    for key, parts in kept.items():
        values = getattr(part, key)
        if values is not None:
            yield from ((f"{name}_{key}_{c}", values[:, i]) for i, c in enumerate(parts))
