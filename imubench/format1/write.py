"""How a recording is spread over the files of format 1."""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w

from imubench.arrays import Array
from imubench.atomic import atomic_directory
from imubench.errors import InputError, unknown
from imubench.format1.keys import FILE_NAME, FORMAT, KEYS, LISTS, Declared
from imubench.format1.profile_noise import by_profile
from imubench.format1.tables import write_table
from imubench.inputs.files import read_bytes
from imubench.models import is_rig
from imubench.recording import Recording
from imubench.reference import Reference

IMU = {"gyro": ("gyr_x", "gyr_y", "gyr_z"), "accel": ("acc_x", "acc_y", "acc_z")}
ANGLE = "angle"
POSITION = ("x", "y", "z")
QUATERNION = ("qw", "qx", "qy", "qz")
REFERENCE = {
    "hinge_angle": ("hinge_angle",),
    "quaternion1": ("q1_w", "q1_x", "q1_y", "q1_z"),
    "quaternion2": ("q2_w", "q2_x", "q2_y", "q2_z"),
    "joint_position": ("joint_x", "joint_y", "joint_z"),
}


def write_recording(
    recording: Recording,
    folder: Path,
    reference: Reference | None = None,
    table: Literal["csv", "parquet"] = "csv",
    rig_file: Path | None = None,
) -> None:
    """Write a recording so that reading it returns the same bits; `folder` is complete or untouched.

    What a default says already is not written. `rig_file` is the MJCF file to be put there as `recording.rig`
    when that is a path. Raises `InputError` for a folder with other things in it (see `imubench.atomic`).
    """
    if table not in ("csv", "parquet"):
        raise unknown("table", table, ("csv", "parquet"))
    if (not is_rig(recording.rig)) != (rig_file is not None):
        want = "an MJCF file" if rig_file is None else "no MJCF file"
        raise InputError(f"{folder}: expected {want} as rig_file for rig '{recording.rig}', got {rig_file}")
    if rig_file is not None:
        Declared(Path(folder) / FILE_NAME, {}, {}).file(recording.rig, "key 'rig'")
    with atomic_directory(folder) as partial:
        write_tables(recording, partial, reference, table)
        if rig_file is not None:
            target = partial / recording.rig
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(read_bytes(rig_file))


def write_tables(recording: Recording, folder: Path, reference: Reference | None, suffix: str) -> None:
    """Write recording.toml and one table per sensor into an empty folder."""
    content: dict[str, Any] = {"format": FORMAT, **_facts("", recording)}
    imus, encoders, poses = [], [], []
    for imu in recording.imus:
        name = f"{imu.name}.{suffix}"
        write_table(folder / name, _columns(imu.time, {IMU["gyro"]: imu.gyro, IMU["accel"]: imu.accel}))
        told = by_profile(imu)
        facts = {key: value for key, value in _facts("imu", imu).items() if key not in told}
        imus.append(_with_file(facts, name))
    for i, encoder in enumerate(recording.encoders):
        name = f"encoder{i + 1 if i else ''}.{suffix}"
        write_table(folder / name, _columns(encoder.time, {(ANGLE,): encoder.angle}))
        encoders.append(_with_file(_facts("encoder", encoder), name))
    for i, pose in enumerate(recording.poses):
        name = f"pose{i + 1}.{suffix}"
        write_table(folder / name, _columns(pose.time, {POSITION: pose.position, QUATERNION: pose.quaternion}))
        poses.append(_with_file(_facts("pose", pose), name))
    swings = [{"start": float(start), "end": float(end)} for start, end in recording.free_swings]
    for kind, entries in (("imu", imus), ("encoder", encoders), ("pose", poses), ("free_swing", swings)):
        if entries:
            content[kind] = entries
    if recording.body is not None:
        content["body"] = _facts("body", recording.body)
    if reference is not None:
        name = f"reference.{suffix}"
        groups: dict[tuple[str, ...], Array | None] = {
            columns: getattr(reference, key) for key, columns in REFERENCE.items()
        }
        write_table(folder / name, _columns(reference.time, groups))
        content["reference"] = {"file": name}
    (folder / FILE_NAME).write_bytes(_toml(content).encode())


def _toml(content: Mapping[str, Any]) -> str:
    """Return TOML as one would type it, a `[[imu]]` per IMU and vectors on one line; the values are tomli_w's."""

    def table(entry: Mapping[str, Any]) -> list[str]:
        return [f"{key} = {value(item)}" for key, item in entry.items()]

    def value(item: Any) -> str:
        if isinstance(item, list):
            return "[" + ", ".join(map(value, item)) + "]"
        return tomli_w.dumps({"x": item}).removeprefix("x = ").rstrip("\n")

    lines = table({key: item for key, item in content.items() if key in KEYS[""]})
    for kind, entries in content.items():
        if kind in LISTS:
            for entry in entries:
                lines += ["", f"[[{kind}]]", *table(entry)]
        elif kind not in KEYS[""]:
            lines += ["", f"[{kind}]", *table(entries)]
    return "\n".join(lines) + "\n"


def _columns(time: Array, groups: Mapping[tuple[str, ...], Array | None]) -> dict[str, Array]:
    columns = {"time": time}
    for names, values in groups.items():
        if values is not None:
            columns.update(zip(names, values.reshape(len(time), -1).T, strict=True))
    return columns


def _facts(kind: str, thing: Any) -> dict[str, Any]:
    """Return the declared fields of a recording, sensor or body, without those at their defaults."""
    facts = {}
    for field in fields(thing):
        if field.name not in KEYS[kind]:
            continue
        value = _plain(getattr(thing, field.name))
        default = field.default if field.default_factory is MISSING else _plain(field.default_factory())
        if value is not None and (default is MISSING or repr(value) != repr(default)):  # repr: -0.0 is not 0.0
            facts[field.name] = value
    return facts


def _plain(value: Any) -> Any:
    """Return arrays as lists and every number as a float."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    return float(value) if isinstance(value, int | float | np.number) else value


def _with_file(facts: dict[str, Any], name: str) -> dict[str, Any]:
    """Put the file behind the first key, the name of the sensor."""
    first, *rest = facts.items()
    return dict([first, ("file", name), *rest])
