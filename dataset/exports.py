"""Recordings of a dataset in the forms that other tools take. A new form is one function and one line in `EXPORTS`.

format1  one folder a recording, as a laboratory's, with the truth as its reference
qmt      one .mat a recording, as `qmt.Struct.load` and MATLAB read it: rows in which every IMU has a sample
opensim  three .sto tables a recording, named and laid out as OpenSim's own IMU readers write them
ring     X and y as `imt-ring` trains on, one .npz for each number of IMUs; a lost sample repeats the one before
"""

from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import reduce
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from imubench import rotations
from imubench.arrays import Array
from imubench.dataset.playing import rows_of
from imubench.dataset.reading import Stored
from imubench.errors import InputError
from imubench.format1 import write_recording
from imubench.recording import Imu
from imubench.truth import SensorTruth, Truth

MATLAB_HEADER = b"MATLAB 5.0 MAT-file, written by imubench".ljust(116)  # the text that a file of version 5 begins with
OPENSIM_HEADER = "DataRate={rate:.6f}\nDataType={kind}\nversion=3\nOpenSimVersion=4.5\nendheader\n"


def export_format1(recordings: Iterator[Stored], folder: Path) -> None:
    """Write NAME/: recording.toml, a CSV file for each sensor, and reference.csv of what is stored of the truth."""
    for stored in recordings:
        if stored.reference is not None:
            _check_within(stored, stored.reference.time.size)
        write_recording(stored.recording, folder / stored.recording.name, stored.reference)


def export_qmt(recordings: Iterator[Stored], folder: Path) -> None:
    """Write NAME.mat: t, rate, and imu1, imu2 with gyr, acc, and quat (sensor -> world), joint vector and axis."""
    for stored in recordings:
        truth, imus = _truth(stored), stored.recording.imus
        rows = [rows_of(imu.time, imu.rate) for imu in imus]
        common = reduce(np.intersect1d, rows)
        content: dict[str, object] = {"name": stored.recording.name, "rate": imus[0].rate, "t": truth.time[common]}
        for imu, own in zip(imus, rows, strict=True):
            kept, sensor = np.isin(own, common), truth.sensor(imu.name)
            part: dict[str, object] = {"gyr": imu.gyro[kept], "acc": imu.accel[kept], "t": imu.time[kept]}
            part |= {"quat": sensor.quaternion[common], "joint_vector": sensor.joint_vector[common]}
            if sensor.joint_axis is not None:
                part["joint_axis"] = sensor.joint_axis[common]
            content[imu.name] = part
        buffer = BytesIO()
        savemat(buffer, content, do_compression=True, oned_as="column")
        buffer.seek(0)
        buffer.write(MATLAB_HEADER)  # SciPy's has the time of day, and the same export is to be the same bytes
        (folder / f"{stored.recording.name}.mat").write_bytes(buffer.getvalue())


def export_opensim(recordings: Iterator[Stored], folder: Path) -> None:
    """Write NAME_orientations.sto (the truth), NAME_linear_accelerations.sto and NAME_angular_velocity.sto (as read).

    World is z up, as in the dataset: OpenSense turns it with `sensor_to_opensim_rotations` = (-pi/2, 0, 0).
    """
    for stored in recordings:
        truth, imus = _truth(stored), stored.recording.imus
        held = {imu.name: held_rows(imu, truth.time.size) for imu in imus}
        tables = {
            "orientations": ("Quaternion", {s.name: s.quaternion for s in truth.sensors}),
            "linear_accelerations": ("Vec3", {i.name: i.accel[held[i.name]] for i in imus}),
            "angular_velocity": ("Vec3", {i.name: i.gyro[held[i.name]] for i in imus}),
        }
        for what, (kind, columns) in tables.items():
            with (folder / f"{stored.recording.name}_{what}.sto").open("w", encoding="utf-8", newline="\n") as file:
                file.write(OPENSIM_HEADER.format(rate=imus[0].rate, kind=kind))
                file.write("\t".join(["time", *(f"{name}_imu" for name in columns)]) + "\n")
                cells = [[",".join(f"{x:.9g}" for x in row) for row in values] for values in columns.values()]
                file.writelines(
                    "\t".join([f"{t:.9g}", *row]) + "\n" for t, *row in zip(truth.time, *cells, strict=True)
                )


def export_ring(recordings: Iterator[Stored], folder: Path) -> None:
    """Write imus-N.npz: X (B, T, N, 9) acc, gyr, joint axis; y (B, T, N, 4); lam (N,), Ts and recording (B,).

    Bodies are the sensors. y of the first is its inclination, world -> sensor without the heading; y of the second
    is sensor 2 -> sensor 1: the conventions of `imt-ring`'s generator. T is that of the shortest recording.
    """
    groups: dict[int, list[tuple[int, NDArray[np.float32], NDArray[np.float32]]]] = defaultdict(list)
    step = 0.0
    for stored in recordings:
        truth, imus = _truth(stored), stored.recording.imus
        features = [_features(imu, truth.sensor(imu.name), first=i == 0) for i, imu in enumerate(imus)]
        x = np.stack(features, axis=1).astype(np.float32)
        y = np.stack(_targets([s.quaternion for s in truth.sensors]), axis=1).astype(np.float32)
        groups[len(imus)].append((int(stored.row["recording"]), x, y))
        step = 1.0 / imus[0].rate
    for count, found in groups.items():
        length = min(len(x) for _, x, _ in found)
        np.savez(
            folder / f"imus-{count}.npz",
            X=np.stack([x[:length] for _, x, _ in found]),
            y=np.stack([y[:length] for _, _, y in found]),
            lam=np.arange(count) - 1,
            Ts=np.array(step),
            recording=np.array([index for index, _, _ in found]),
        )


def _features(imu: Imu, sensor: SensorTruth, first: bool) -> Array:
    held = held_rows(imu, len(sensor.gyro))
    none = first or sensor.joint_axis is None
    axis = np.zeros_like(sensor.gyro) if none else np.asarray(sensor.joint_axis)
    return np.concatenate([imu.accel[held], imu.gyro[held], axis], axis=-1)


def _targets(quaternions: list[Array]) -> list[Array]:
    """Return inclination (world -> first sensor, heading taken out) and relative orientations (child -> parent)."""
    first = quaternions[0]
    heading = 2 * np.arctan2(first[:, 3], first[:, 0])
    turned_back = rotations.from_axis_angle(np.array([0.0, 0.0, 1.0]), -heading)
    inclination = rotations.conjugate(rotations.multiply(turned_back, first))
    related = (rotations.multiply(rotations.conjugate(p), c) for p, c in pairwise(quaternions))
    return [inclination, *related]


def held_rows(imu: Imu, count: int) -> NDArray[np.intp]:
    """Return, for each of `count` rows, which of an IMU's samples to take: its own, else the last one before."""
    found = np.searchsorted(rows_of(imu.time, imu.rate), np.arange(count), side="right") - 1
    return np.maximum(found, 0)


def _truth(stored: Stored) -> Truth:
    if stored.truth is None:
        raise InputError('export: expected a dataset with truth = "full", got less')
    _check_within(stored, stored.truth.time.size)
    return stored.truth


def _check_within(stored: Stored, count: int) -> None:
    """Raise `InputError` where an IMU has samples beyond so many rows of truth."""
    for imu in stored.recording.imus:
        rows = rows_of(imu.time, imu.rate)
        if not (rows.min() >= 0 and rows.max() < count):
            raise InputError(
                f"{stored.recording.name}: expected samples of {imu.name} within the {count} rows of truth, got them "
                f"from row {rows.min()} to {rows.max()}"
            )


Export = Callable[[Iterator[Stored], Path], None]
EXPORTS: dict[str, Export] = {
    "format1": export_format1,
    "qmt": export_qmt,
    "opensim": export_opensim,
    "ring": export_ring,
}
"""The forms by name; each takes recordings one after the other and a folder to write to."""
