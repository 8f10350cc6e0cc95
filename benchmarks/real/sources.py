"""The recordings in IMUBENCH_DATA: how long each is, and how it is converted."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from benchmarks.real_axes import JOINTS, trial
from imubench.arrays import Array
from imubench.convert import CONVERTERS
from imubench.convert.table import read_columns, read_lines, stack
from imubench.errors import InputError
from imubench.inputs.hdf5 import read_hdf5
from imubench.recording import Imu, Recording
from imubench.reference import Reference

MOUNTS = {"foam": "nonrigid", "rigid": "rigid"}
PENDULUM = "SinglePendulumDataForParameterEstimation.mat"
FERRARIS, FERRARIS_RATE = "example_ferraris_session.csv", 102.4  # Hz, as imucal's example says
DOT_PREAMBLE = 30  # lines within which the header of a Movella DOT export must come
DOT_TICK = 1e-6  # s, of SampleTimeFine


@dataclass(frozen=True)
class Loaded:
    """A whole recording, the record that judges it, and the hinge axes that are known apart from both."""

    recording: Recording
    reference: Reference | None
    axes: Array | None  # (2, 3) in the axes of imu1 and imu2, from the screwed-on IMUs


@dataclass(frozen=True)
class Source:
    """A recording of the collection by its name, such as diodem/trial1/3-4-foam."""

    name: str
    seconds: float
    load: Callable[[], Loaded]


def sources(data: Path) -> Iterator[Source]:
    """Yield every recording below a folder, in the order of their names within each collection."""
    for made in (_diodem, _broad, _multiarm, _imucal, _dot_knee):
        yield from made(data)


def _diodem(data: Path) -> Iterator[Source]:
    for folder in sorted(p.parent for p in (data / "diodem").glob("*/omc.csv")):
        rows = read_columns(folder / "imu_rigid.csv", ["seg3_gyr_x"], header_line=2)["seg3_gyr_x"]
        rate = float(read_lines(folder / "imu_rigid.csv", 1)[0].rpartition(":")[2])
        for joint in JOINTS:
            for mount in MOUNTS:
                name = f"diodem/{folder.name}/{joint}-{mount}"
                yield Source(name, (rows.size - 1) / rate, partial(_hinge, folder, joint, MOUNTS[mount]))


@cache
def _hinge(folder: Path, joint: str, mount: str) -> Loaded:
    (made,) = CONVERTERS["diodem"](folder, segments=joint, imu=mount)
    return Loaded(made.recording, made.reference, trial(folder, joint, mount)[1]["declared"])


def _broad(data: Path) -> Iterator[Source]:
    for file in sorted((data / "broad").glob("*.hdf5")):
        found = read_hdf5(file, ("imu_gyr",), (), ("sampling_rate",))
        seconds = (len(found.arrays["imu_gyr"]) - 1) / found.attributes["sampling_rate"]
        yield Source(f"broad/{file.stem}", seconds, partial(_converted, "broad", file))


def _multiarm(data: Path) -> Iterator[Source]:
    file = data / "multiarm" / PENDULUM
    if file.is_file():
        for made in CONVERTERS["multiarm"](file):
            time = made.recording.encoders[0].time
            piece = made.recording.name.removeprefix("multiarm-")
            yield Source(
                f"multiarm/{piece}", float(time[-1] - time[0]), partial(_converted, "multiarm", file, piece=piece)
            )


def _imucal(data: Path) -> Iterator[Source]:
    file = data / "imucal" / FERRARIS
    if file.is_file():
        rows = read_columns(file, ["n_samples"])["n_samples"]
        load = partial(_converted, "csv", file, gyro_unit="deg/s", rate=str(FERRARIS_RATE))
        yield Source("imucal/ferraris", (rows.size - 1) / FERRARIS_RATE, load)


def _dot_knee(data: Path) -> Iterator[Source]:
    folder = data / "dot-knee"
    if (folder / "femur.csv").is_file():
        time = knee(folder).imus[0].time
        yield Source("dot-knee/walk", float(time[-1] - time[0]), lambda: Loaded(knee(folder), None, None))


def _converted(converter: str, file: Path, **options: str) -> Loaded:
    (made,) = CONVERTERS[converter](file, **options)
    return Loaded(made.recording, made.reference, None)


def knee(folder: Path) -> Recording:
    """Return the thigh and the shank, each a Movella DOT, as a hinge; nothing is declared of the mounts.

    Their SampleTimeFine counts on one clock, which the app synchronised.
    """
    imus = [_dot(folder / f"{segment}.csv", f"imu{i + 1}") for i, segment in enumerate(("femur", "tibia"))]
    start = min(i.time[0] for i in imus)
    return Recording("dot-knee", "hinge", tuple(replace(i, time=i.time - start) for i in imus))


def _dot(path: Path, name: str) -> Imu:
    """Return one sensor of an export of the Movella DOT app: a preamble, then a table in us, m/s^2 and deg/s."""
    for above in range(DOT_PREAMBLE):
        if read_lines(path, above + 1)[-1].startswith("PacketCounter,"):
            break
    else:
        raise InputError(f"{path}: expected a line that begins with PacketCounter within {DOT_PREAMBLE}, got none")
    names = [f"{kind}_{axis}" for kind in ("Gyr", "Acc") for axis in "XYZ"]
    table = read_columns(path, ["SampleTimeFine", *names], header_line=above)
    time = table["SampleTimeFine"] * DOT_TICK
    rate = float(f"{1 / np.median(np.diff(time)):.4g}")
    return Imu(name, time, np.deg2rad(stack(table, names[:3])), stack(table, names[3:]), rate)
