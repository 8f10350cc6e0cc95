"""A dataset is read back: one recording with its truth by one call, each of its files by any Parquet reader."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from imubench.arrays import Array
from imubench.dataset.columns import POSE_FIELDS, SEGMENT_FIELDS, SENSOR_FIELDS, SHARED_ORIGIN, SIGNALS, XYZ
from imubench.dataset.instruments import SEGMENTS
from imubench.dataset.manifest import MANIFEST, read_manifest
from imubench.dataset.remote import place
from imubench.dataset.storage import Place
from imubench.errors import InputError, first_line, unknown
from imubench.inputs.files import plain_name
from imubench.inputs.json import parse_json
from imubench.inputs.parquet import opened_parquet
from imubench.inputs.tables import check_size
from imubench.models import is_rig, known_rigs
from imubench.models.tree import rig_tree
from imubench.recording import Body, Encoder, Imu, Pose, Recording
from imubench.reference import Reference
from imubench.truth import SegmentTruth, SensorTruth, Truth

TABLE = re.compile(r"recordings/([\w.]+-(\d{5,10})\.parquet)", re.ASCII)  # one of a shard, whose number it has


@dataclass(frozen=True)
class Stored:
    """One recording of a dataset, as its files have it."""

    recording: Recording
    truth: Truth | None  # on the grid of the recording's rate; None unless the spec says truth = "full"
    row: Mapping[str, Any]  # of the table of recordings: all that was drawn
    effects: tuple[dict[str, Any], ...]  # {"effect", "at", "parameters"}
    reference: Reference | None = None  # of the truth what a laboratory could measure; None where nothing is stored


def read(folder: Path | str, index: int) -> Stored:
    """Return recording `index` of a finished dataset, without reading its neighbours.

    Numbers are those on the disk: with `precision = "single"`, rounded to 24 bits. Raises `InputError` for a folder
    that is no finished dataset, a number that is not in it, or a file that cannot be read.
    """
    contents = _contents(str(folder))
    if not 0 <= index < contents.count:
        raise InputError(f"{folder}: expected a recording from 0 to {contents.count - 1}, got {index}")
    where = place(str(folder))
    here = f"{folder}, recording {index}"
    try:
        name, group = _found(where, contents.tables(index // contents.size), index)
        recordings, samples = f"recordings/{name}", f"samples/{name}"
        with where.reading(recordings) as source, opened_parquet(source, f"{folder}/{recordings}") as file:
            row = file.read(use_threads=False).slice(group, 1).to_pylist()[0]
        with where.reading(samples) as source, opened_parquet(source, f"{folder}/{samples}") as file:
            found = file.metadata.row_group(group)
            check_size(Path(samples), found.num_rows, found.num_columns)
            table = file.read_row_group(group, use_threads=False)
        plain_name(row["name"], f"{here}: name")
        effects = tuple(
            e | {"parameters": parse_json(e["parameters"].encode(), f"{here}: effects")} for e in row["effects"]
        )
        return Stored(_recording(row, table), _truth(row, table), row, effects, _reference(row, table))
    except InputError as error:
        raise InputError(f"{here}: {error}") from None
    except (OSError, pa.ArrowException, LookupError, TypeError, ValueError, AttributeError) as error:
        reason = f"{type(error).__name__}: {first_line(error)}"  # columns that are not there, or hold something else
        raise InputError(f"{here}: expected the files of a dataset, got: {reason}") from None


def indices(folder: Path | str, split: str | None = None) -> Iterator[int]:
    """Yield the numbers of all recordings, or of those of a split; `InputError` names the known splits."""
    where = place(str(folder))
    found = read_manifest(where)
    if split is not None and split not in found["recordings"]:
        raise unknown("split", split, found["recordings"])
    contents = Contents.of(found)
    for number in range(-(-contents.count // contents.size)):
        rows = [pair for name in contents.tables(number) for pair in _numbered(where, name)]
        yield from sorted(index for index, own in rows if split in (None, own))


@dataclass(frozen=True)
class Contents:
    """Which files hold which recordings, as a manifest says."""

    count: int  # recordings
    size: int  # of a shard
    shards: Mapping[int, tuple[str, ...]]  # number -> names of its tables, the same for samples and recordings

    @classmethod
    def of(cls, manifest: Mapping[str, Any]) -> "Contents":
        """Return the contents of a dataset of any format that `read_manifest` takes."""
        shards: dict[int, tuple[str, ...]] = {}
        for file in manifest["files"]:
            if named := TABLE.fullmatch(file):
                shards[int(named[2])] = (*shards.get(int(named[2]), ()), named[1])
        return cls(int(manifest["count"]), int(manifest["recordings_per_file"]), shards)

    def tables(self, number: int) -> tuple[str, ...]:
        """Return the names of the tables of a shard; `InputError` where the manifest has none."""
        if number not in self.shards:
            raise InputError(f"expected the files of shard {number} in {MANIFEST}, got none")
        return self.shards[number]


def _numbered(where: Place, table: str) -> list[tuple[int, str]]:
    """Return number and split of each recording in a table of recordings."""
    name = f"recordings/{table}"
    with where.reading(name) as source, opened_parquet(source, f"{where.path}/{name}") as file:
        check_size(Path(name), file.metadata.num_rows, file.metadata.num_columns)
        for column in ("recording", "split"):
            if column not in file.schema_arrow.names:
                raise InputError(f"{where.path}/{name}: expected column '{column}', got none")
        if not pa.types.is_integer(file.schema_arrow.field("recording").type):
            kind = file.schema_arrow.field("recording").type
            raise InputError(f"{where.path}/{name}, column 'recording': expected whole numbers, got {kind}")
        found = file.read(columns=["recording", "split"], use_threads=False)
        if found.column("recording").null_count:
            raise InputError(f"{where.path}/{name}, column 'recording': expected whole numbers, got nulls")
    return list(zip(*(found.column(name).to_pylist() for name in ("recording", "split")), strict=True))


def _found(where: Place, tables: Sequence[str], index: int) -> tuple[str, int]:
    """Return which of a shard's tables has a recording, and its row there, that is the row group of its samples."""
    for name in tables:
        for row, (number, _) in enumerate(_numbered(where, name)):
            if number == index:
                return name, row
    raise InputError(f"expected recording {index} in {' or '.join(tables)}, got other recordings")


@lru_cache(maxsize=16)
def _contents(folder: str) -> Contents:
    return Contents.of(read_manifest(place(folder)))


def _recording(row: Mapping[str, Any], table: pa.Table) -> Recording:
    if not is_rig(row["family"]):
        raise unknown("rig", row["family"], known_rigs())
    sensors = rig_tree(row["family"]).imus
    free = row["free_swing"] is not None
    return Recording(
        name=row["name"],
        rig=row["family"],
        imus=tuple(_imu(name, row, table) for name in sensors),
        encoders=_encoders(row, table),
        poses=_poses(row, table),
        gravity=row["gravity"],
        motion="free" if free else "hand",
        free_swings=(tuple(row["free_swing"]),) if free else (),
        body=Body(row["body_mass"], row["body_com"], row["body_inertia"]) if free else None,
        base=row["base"],
        base_quaternion=row["base_quaternion"],
    )


def _encoders(row: Mapping[str, Any], table: pa.Table) -> tuple[Encoder, ...]:
    if row["encoder_noise_std"] is None:
        return ()
    time, angle = _column(table, "time"), _column(table, "encoder_angle")
    hinge = rig_tree(row["family"]).hinge
    assert hinge is not None  # a dataset draws an encoder where there is one to measure
    return (Encoder(hinge.name, time, angle, row["encoder_noise_std"], row["encoder_zero"]),)


def _poses(row: Mapping[str, Any], table: pa.Table) -> tuple[Pose, ...]:
    names = [name for name in SEGMENTS if row.get(f"{name}_measured_position_std") is not None]
    return tuple(_pose(name, row, table) for name in names)


def _pose(name: str, row: Mapping[str, Any], table: pa.Table) -> Pose:
    position, quaternion = (_stacked(table, f"{name}_measured_{key}", parts) for key, parts in POSE_FIELDS.items())
    stds = (row[f"{name}_measured_{key}_std"] for key in ("position", "rotation"))
    return Pose(name, _column(table, "time"), position, quaternion, *stds)


def _imu(name: str, row: Mapping[str, Any], table: pa.Table) -> Imu:
    there = np.asarray(table.column(f"{name}_time").is_valid())
    signals = {key: _stacked(table, f"{name}_{short}", XYZ)[there] for key, short in SIGNALS}
    declared = ("gyro_noise_std", "accel_noise_std", "gyro_range", "accel_range")
    return Imu(
        name=name,
        time=_column(table, f"{name}_time")[there],
        rate=row["rate"],
        mount_position=row[f"{name}_declared_position"],
        mount_quaternion=row[f"{name}_declared_quaternion"],
        mount_position_std=row[f"{name}_declared_position_std"],
        mount_rotation_std=row[f"{name}_declared_rotation_std"],
        **signals,
        **{key: row[f"{name}_{key}"] for key in declared},
    )


def _truth(row: Mapping[str, Any], table: pa.Table) -> Truth | None:
    if "segment1_position_x" not in table.column_names:
        return None
    tree = rig_tree(row["family"])
    hinge, names = tree.hinge is not None, tree.names
    segments: list[SegmentTruth] = []
    for name in names:
        shared = {key: getattr(segments[0], key) for key in SHARED_ORIGIN} if segments else {}
        own = {k: _stacked(table, f"{name}_{k}", c) for k, c in SEGMENT_FIELDS.items() if k not in shared}
        segments.append(SegmentTruth(name, **(shared | own)))
    sensors = []
    for imu in tree.imus:
        fields = {
            key: None if key == "joint_axis" and not hinge else _stacked(table, f"{imu}_true_{key}", parts)
            for key, parts in SENSOR_FIELDS.items()
        }
        sensors.append(SensorTruth(imu, **fields))  # type: ignore[arg-type]
    angle, rate = (_column(table, f"hinge_{key}") if hinge else None for key in ("angle", "rate"))
    time = _column(table, "time")
    return Truth(time, row["family"], row["true_gravity"], tuple(segments), tuple(sensors), angle, rate)


def _reference(row: Mapping[str, Any], table: pa.Table) -> Reference | None:
    groups: dict[str, Array] = {}
    tree = rig_tree(row["family"])
    if tree.hinge is not None and "hinge_angle" in table.column_names:
        groups["hinge_angle"] = _column(table, "hinge_angle")
    for n, name in enumerate(tree.names, 1):
        if f"{name}_quaternion_w" in table.column_names:
            groups[f"quaternion{n}"] = _stacked(table, f"{name}_quaternion", SEGMENT_FIELDS["quaternion"])
    if not tree.loose and "segment1_position_x" in table.column_names:
        groups["joint_position"] = _stacked(table, "segment1_position", XYZ)
    return Reference(_column(table, "time"), **groups) if groups else None


def _column(table: pa.Table, name: str) -> Array:
    return np.asarray(table.column(name).to_numpy(), dtype=float)


def _stacked(table: pa.Table, name: str, parts: str) -> Array:
    return np.stack([_column(table, f"{name}_{c}") for c in parts], axis=-1)
