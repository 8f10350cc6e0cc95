"""One or two CSV files with a header: an IMU each."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from imubench.arrays import Array, frozen_time
from imubench.convert.converter import Converted, Converter, Option, choice, number
from imubench.convert.stamps import TIME_UNITS, Stamps, in_seconds
from imubench.convert.table import read_columns, read_header, stack
from imubench.errors import InputError, unknown
from imubench.inputs.files import NOTHING, what_is
from imubench.inputs.tables import listed
from imubench.models import is_rig, known_rigs
from imubench.recording import STANDARD_GRAVITY, Imu, Recording

COLUMNS = ("time", "gyr_x", "gyr_y", "gyr_z", "acc_x", "acc_y", "acc_z")
GYRO_UNITS = {"rad/s": 1.0, "deg/s": np.pi / 180}
ACCEL_UNITS = {"m/s^2": 1.0, "g": 9.80665}
NAME_THEM = "say which is which: --option columns=time=T,gyr_x=X,... with the file's own names"
FASTEST = 100.0  # rad/s, beyond the 5,700 deg/s of any common gyroscope


def parse_columns(text: str) -> object:
    """Return {our name: file's name} of `gyr_x=wx,gyr_y=wy`; `InputError` names our columns."""
    pairs = [pair.partition("=") for pair in text.split(",")]
    if not all(sign for _, sign, _ in pairs):
        raise InputError(f"columns: expected pairs such as gyr_x=wx,acc_x=ax, got '{text}'")
    names = {ours.strip(): theirs.strip() for ours, _, theirs in pairs}
    for ours in names:
        if ours not in COLUMNS:
            raise unknown("column", ours, COLUMNS)
    return names


def convert(
    source: Path,
    second: str = "",
    columns: Mapping[str, str] | None = None,
    columns2: Mapping[str, str] | None = None,
    gyro_unit: str = "rad/s",
    accel_unit: str = "m/s^2",
    time_unit: str = "",
    rate: float | None = None,
    rig: str = "",
    start: float = 0.0,
    end: float | None = None,
) -> list[Converted]:
    """Return one recording of the IMU in `source` and, if given, of the one in `second`.

    Without a `time` column the stamps are k / `rate`; with one, `rate` defaults to the median step's.
    `columns2` names the second IMU's columns and defaults to `columns`; `second` may be the same file.
    `time_unit` defaults to s. Large stamps, such as those since 1970, count from the first one's second, which the
    note says. Of the time from the first stamp on, what lies from `start` to `end` s is taken. Raises `InputError`
    when the units cannot be right: at its slowest turning the IMU must read about 9.81 m/s^2, and give over one
    sample a second.
    """
    files = [(source, columns or {})]
    if second:
        beside = source.parent / second
        files.append((beside if what_is(beside) != NOTHING else Path(second), columns2 or columns or {}))
    read = [_read(path, names, rate) for path, names in files]
    moved, note = in_seconds([stamps for stamps, _, _ in read if isinstance(stamps, Stamps)], time_unit)
    stamped, imus = iter(moved), []
    first = min([float(stamps[0]) for stamps in moved if stamps.size], default=0.0)
    for i, ((path, _), (stamps, gyro, accel)) in enumerate(zip(files, read, strict=True)):
        time = next(stamped) if isinstance(stamps, Stamps) else stamps
        gyro, accel = gyro * GYRO_UNITS[gyro_unit], accel * ACCEL_UNITS[accel_unit]
        hertz = rate or _rate(time)
        part = _part(time - first, start, end, path)
        time, gyro, accel = time[part], gyro[part], accel[part]
        imus.append(Imu(name=f"imu{i + 1}", time=time, gyro=gyro, accel=accel, rate=hertz))
        _check_units(path, imus[-1], gyro_unit, accel_unit)
    recording = Recording(name=source.stem, rig=rig or ("hinge" if second else "free"), imus=tuple(imus))
    note += (
        f"From {', '.join(path.name for path, _ in files)}, gyroscope in {gyro_unit}, accelerometer in {accel_unit}. "
        "Mount poses and noise are not declared: add them to recording.toml."
    )
    return [Converted(recording, None, note)]


def _part(time: Array, start: float, end: float | None, path: Path) -> slice:
    """Return the samples of a time (n,) in s that lie between two; `InputError` where there are none."""
    if start == 0.0 and end is None:
        return slice(None)
    inside = np.flatnonzero((time >= start) & (time <= (np.inf if end is None else end)))
    if not inside.size:
        to = "the end" if end is None else f"{end:g} s"
        raise InputError(f"{path}: expected samples from {start:g} s to {to}, got 0 to {np.max(time, initial=0.0):g} s")
    return slice(int(inside[0]), int(inside[-1]) + 1)


def _rate(time: Array) -> float:
    """Return the rate in Hz of stamps (n,) in s; 1 of a single one, and of those that go backwards, refused later."""
    step = float(np.median(np.diff(time))) if time.size > 1 else 1.0
    return float(f"{1 / step:.9g}") if step > 0 else 1.0  # 100, not 99.9999999976


def _read(path: Path, names: Mapping[str, str], rate: float | None) -> tuple[Stamps | Array, Array, Array]:
    """Return stamps, or time (n,) in s of a file without, and, in the file's units, gyro (n, 3) and accel (n, 3)."""
    theirs = [names.get(name, name) for name in COLUMNS]
    header = read_header(path)
    timed = theirs[0] in header
    if not timed and (rate is None or "time" in names):
        raise InputError(
            f"{path}: expected column '{theirs[0]}' or the option rate, got {listed(header, 10)}; {NAME_THEM}"
        )
    for name in theirs[1:]:
        if name not in header:
            raise InputError(f"{path}: expected column '{name}', got {listed(header, 10)}; {NAME_THEM}")
    table = read_columns(path, theirs if timed else theirs[1:])
    gyro, accel = stack(table, theirs[1:4]), stack(table, theirs[4:])
    if timed:
        stamps = table[theirs[0]]
        frozen_time(stamps, f"{path}, {theirs[0]}")  # in the file's unit, which its owner knows
        return Stamps(path, theirs[0], stamps), gyro, accel
    return np.arange(len(gyro)) / float(rate or 1.0), gyro, accel


def _check_units(path: Path, imu: Imu, gyro_unit: str, accel_unit: str) -> None:
    speed = np.linalg.norm(imu.gyro, axis=-1)
    if speed.max() > FASTEST:
        raise InputError(
            f"{path}, row {int(speed.argmax())}: expected under {FASTEST:g} rad/s, got {speed.max():.3g} from "
            f"gyro_unit '{gyro_unit}'; known: {', '.join(GYRO_UNITS)}"
        )
    slowest = speed <= np.quantile(speed, 0.1)
    force = float(np.median(np.linalg.norm(imu.accel[slowest], axis=-1)))
    if not 0.7 < force / STANDARD_GRAVITY < 1.4:
        raise InputError(
            f"{path}: expected about {STANDARD_GRAVITY} m/s^2 where it turns slowest, got {force:.3g} from "
            f"accel_unit '{accel_unit}'; known: {', '.join(ACCEL_UNITS)}"
        )


def parse_rig(text: str) -> object:
    """Return the name of a rig; `InputError` with those that are known."""
    if not is_rig(text):
        raise unknown("rig", text, known_rigs())
    return text


CONVERTER = Converter(
    "csv",
    "one or two CSV files with a header, an IMU each",
    convert,
    {
        "second": Option("the second IMU's file, beside the first or anywhere", str, file=True),
        "columns": Option("our names and the file's: time=t,gyr_x=wx,acc_x=ax", parse_columns),
        "columns2": Option("the same for the second IMU, if it differs", parse_columns),
        "gyro_unit": Option("rad/s or deg/s", choice("gyro_unit", tuple(GYRO_UNITS))),
        "accel_unit": Option("m/s^2 or g", choice("accel_unit", tuple(ACCEL_UNITS))),
        "time_unit": Option("s, ms, us or ns; s where it is not said", choice("time_unit", tuple(TIME_UNITS))),
        "rate": Option("Hz, for files without stamps", number("rate", above_zero=True)),
        "rig": Option("hinge, pendulum or free, or a package's", parse_rig),
        "start": Option("s from the first stamp on: what is before is left out", number("start")),
        "end": Option("s from the first stamp on: what is after is left out", number("end", above_zero=True)),
    },
)
