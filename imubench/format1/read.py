"""Format 1 on disk: a folder with recording.toml and one table of numbers per sensor, read and written exactly.

Reading raises `InputError`, one line that names file, line or key, for everything that is not a recording in
this format or that no instrument could have measured in its units. Extra columns beside an IMU's or an encoder's are
passed over; an unknown key, or an unknown column where columns are optional, is an error.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from imubench.arrays import Array
from imubench.errors import InputError, unknown
from imubench.format1.keys import FILE_NAME, Declared, read_declared, title
from imubench.format1.physics_checks import check_imu
from imubench.format1.profile_noise import profile_noise
from imubench.format1.track_checks import check_angle, check_lever, check_position, check_quaternions
from imubench.format1.write import ANGLE, IMU, POSITION, QUATERNION, REFERENCE
from imubench.inputs.files import what_is
from imubench.inputs.tables import Table, read_table
from imubench.models import is_rig, known_rigs
from imubench.models.tree import rig_tree
from imubench.recording import STANDARD_GRAVITY, Body, Encoder, Imu, Pose, Recording
from imubench.reference import Reference


def read(folder: Path) -> tuple[Recording, Reference | None]:
    """Return a recording and its reference, which must overlap in time."""
    recording, reference = read_recording(folder), read_reference(folder)
    if reference is not None:
        _check_overlap(Path(folder) / FILE_NAME, recording.imus, "[reference]", reference.time)
    return recording, reference


def read_recording(folder: Path) -> Recording:
    """Return the recording in a folder; its reference stays unread.

    `rig` is kept as it is declared: an MJCF file's path is relative to the folder. Raises `InputError`, see above.
    """
    declared = read_declared(folder)
    top, tables = dict(declared.top), declared.tables
    del top["format"]
    _check_rig(declared, top["rig"])
    gravity = top.get("gravity", STANDARD_GRAVITY)
    files: dict[str, str] = {}
    for i, entry in enumerate(tables["imu"]):
        if entry["file"] in files:
            raise InputError(
                f"{declared.path}, {title('imu', i)}, key 'file': expected a file of its own, "
                f"got {entry['file']} of {files[entry['file']]}"
            )
        files[entry["file"]] = entry["name"]
    imus = tuple(_read_imu(declared, i, entry, gravity) for i, entry in enumerate(tables["imu"]))
    encoders = tuple(_read_encoder(declared, i, entry) for i, entry in enumerate(tables["encoder"]))
    poses = tuple(_read_pose(declared, i, entry) for i, entry in enumerate(tables["pose"]))
    for i, encoder in enumerate(encoders):
        _check_overlap(declared.path, imus, title("encoder", i), encoder.time)
    for i, pose in enumerate(poses):
        _check_overlap(declared.path, imus, title("pose", i), pose.time)
    swings = tuple((entry["start"], entry["end"]) for entry in tables["free_swing"])
    with _naming(declared.path):
        body = Body(**tables["body"][0]) if tables["body"] else None
        recording = Recording(**top, imus=imus, encoders=encoders, poses=poses, free_swings=swings, body=body)
    if body is not None:
        check_lever(body.com, f"{declared.path}, [body], key 'com'")
    _check_swings(declared.path, recording)
    return recording


def read_reference(folder: Path) -> Reference | None:
    """Return the reference in a recording's folder, None where none is declared; `InputError`, see above."""
    declared = read_declared(folder)
    if not declared.tables["reference"]:
        return None
    text = declared.tables["reference"][0]["file"]
    names = [name for group in REFERENCE.values() for name in group]
    path, table = _read(declared, text, "[reference], key 'file'", ["time"], names)
    arrays: dict[str, Array | None] = {}
    for key, group in REFERENCE.items():
        arrays[key] = _group(path, table, group, whole=True)
    if arrays["hinge_angle"] is not None:
        arrays["hinge_angle"] = arrays["hinge_angle"][:, 0]
        check_angle(table.columns["time"], arrays["hinge_angle"], table.place, "hinge_angle")
    for key in ("quaternion1", "quaternion2"):
        quaternion = arrays[key]
        if quaternion is not None:
            check_quaternions(quaternion, table.place, f"columns {REFERENCE[key][0]} to {REFERENCE[key][-1]}")
    if arrays["joint_position"] is not None:
        check_position(table.columns["time"], arrays["joint_position"], table.place)
    with _naming(path):
        return Reference(time=table.columns["time"], **arrays)


def _read_imu(declared: Declared, index: int, entry: Mapping[str, Any], gravity: float) -> Imu:
    where = title("imu", index)
    _, table = _read(declared, entry["file"], f"{where}, key 'file'", ["time", *IMU["gyro"], *IMU["accel"]])
    facts = {key: value for key, value in entry.items() if key != "file"}
    with _naming(declared.path):
        if "profile" in facts:
            facts = profile_noise(facts["profile"], facts["rate"]) | facts
        imu = Imu(time=table.columns["time"], gyro=table.stack(IMU["gyro"]), accel=table.stack(IMU["accel"]), **facts)
    check_imu(imu, gravity, table.place, f"{declared.path}, {where}")
    return imu


def _read_encoder(declared: Declared, index: int, entry: Mapping[str, Any]) -> Encoder:
    where, rig = title("encoder", index), declared.top["rig"]
    tree = rig_tree(rig)
    known = [tree.hinge.name] if tree.hinge is not None else ["none with an angle"]
    if (tree.hinge is not None or tree.loose) and entry["joint"] not in known:
        raise InputError(f"{declared.path}, {where}: {unknown(f'joint of rig {rig}', entry['joint'], known)}")
    _, table = _read(declared, entry["file"], f"{where}, key 'file'", ["time", ANGLE])
    check_angle(table.columns["time"], table.columns[ANGLE], table.place, ANGLE)
    facts = {key: value for key, value in entry.items() if key != "file"}
    with _naming(declared.path):
        return Encoder(time=table.columns["time"], angle=table.columns[ANGLE], **facts)


def _read_pose(declared: Declared, index: int, entry: Mapping[str, Any]) -> Pose:
    where, rig = title("pose", index), declared.top["rig"]
    names = rig_tree(rig).names or (entry["segment"],)
    if entry["segment"] not in names:
        raise InputError(f"{declared.path}, {where}: {unknown(f'segment of rig {rig}', entry['segment'], names)}")
    path, table = _read(declared, entry["file"], f"{where}, key 'file'", ["time"], [*POSITION, *QUATERNION])
    position = _group(path, table, POSITION, whole=False)
    quaternion = _group(path, table, QUATERNION, whole=True)
    if position is not None:
        check_position(table.columns["time"], position, table.place)
    if quaternion is not None:
        check_quaternions(quaternion, table.place, "columns qw to qz")
    facts = {key: value for key, value in entry.items() if key != "file"}
    with _naming(path):
        return Pose(time=table.columns["time"], position=position, quaternion=quaternion, **facts)


def _read(
    declared: Declared, text: str, where: str, required: list[str], optional: list[str] | None = None
) -> tuple[Path, Table]:
    """Return the path and the table of a declared file; `x.parquet` is read where `x.csv` is declared but not there."""
    path = declared.file(text, where)
    beside = path.with_suffix(".parquet")
    if path.suffix.lower() == ".csv" and what_is(path) != "a file" and what_is(beside) == "a file":
        path = beside
    return path, read_table(path, required, optional)


def _group(path: Path, table: Table, names: tuple[str, ...], whole: bool) -> Array | None:
    """Return columns that belong together, (n, len(names)), None when none is there; a `whole` group lacks none."""
    there = [name for name in names if name in table.columns]
    missing = [name for name in names if name not in there]
    if there and missing and whole:
        raise InputError(f"{path}: expected column '{missing[0]}' beside '{there[0]}', got no such column")
    return table.stack(names) if there else None


def _check_rig(declared: Declared, rig: str) -> None:
    if is_rig(rig):
        return
    if not rig.endswith(".xml"):
        raise InputError(
            f"{declared.path}, key 'rig': {unknown('rig', rig, [*known_rigs(), 'or an .xml file beside it'])}"
        )
    if what_is(declared.file(rig, "key 'rig'")) != "a file":
        raise InputError(f"{declared.path}, key 'rig': expected an MJCF file beside it, got no file '{rig}'")


def _check_overlap(path: Path, imus: tuple[Imu, ...], where: str, time: Array) -> None:
    for imu in imus:
        if not min(time[-1], imu.time[-1]) >= max(time[0], imu.time[0]):
            raise InputError(
                f"{path}, {where}: expected samples that overlap {imu.name} in time ({imu.time[0]:.12g} to "
                f"{imu.time[-1]:.12g} s), got {time[0]:.12g} to {time[-1]:.12g} s"
            )


def _check_swings(path: Path, recording: Recording) -> None:
    times = [imu.time for imu in recording.imus]
    times += [encoder.time for encoder in recording.encoders] + [pose.time for pose in recording.poses]
    first, last = min(t[0] for t in times), max(t[-1] for t in times)
    for i, (start, end) in enumerate(recording.free_swings):
        if start > last or end < first:
            raise InputError(
                f"{path}, {title('free_swing', i)}: expected a window within {first:.12g} to {last:.12g} s, "
                f"got {start:.12g} to {end:.12g} s"
            )


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Put the file in front of what a type says about its fields."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
