"""The keys of recording.toml: which there are, what each holds, and what is said when one does not fit."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date, time
from math import isfinite
from pathlib import Path
from typing import Any

from imubench.errors import InputError, shown, unknown
from imubench.inputs.files import NOTHING, below, what_is
from imubench.inputs.toml import load_toml

FILE_NAME = "recording.toml"
FORMAT = 1


@dataclass(frozen=True)
class Key:
    """What one key holds: `text`, `number` or `integer`, or with `size` a list of that many numbers."""

    kind: str
    unit: str = ""
    required: bool = False
    size: int = 0

    def __str__(self) -> str:
        what = (
            f"a list of {self.size} numbers"
            if self.size
            else {"integer": "an integer"}.get(self.kind, f"a {self.kind}")
        )
        return f"{what} in {self.unit}" if self.unit else what


def _number(unit: str, required: bool = False) -> Key:
    return Key("number", unit, required)


def _vector(unit: str, required: bool = False) -> Key:
    return Key("number", unit, required, 3)


_TEXT, _QUATERNION = Key("text", required=True), Key("number", "order w, x, y, z", size=4)

KEYS: dict[str, dict[str, Key]] = {
    "": {
        "format": Key("integer", required=True),
        "name": _TEXT,
        "rig": _TEXT,
        "motion": Key("text"),
        "gravity": _number("m/s^2"),
        "base": Key("text"),
        "base_quaternion": _QUATERNION,
    },
    "imu": {
        "name": _TEXT,
        "file": _TEXT,
        "rate": _number("Hz", required=True),
        "gyro_noise_std": _number("rad/s"),
        "accel_noise_std": _number("m/s^2"),
        "gyro_range": _number("rad/s"),
        "accel_range": _number("m/s^2"),
        "mount_position": _vector("m"),
        "mount_quaternion": _QUATERNION,
        "mount_position_std": _number("m"),
        "mount_rotation_std": _number("rad"),
        "profile": Key("text"),
    },
    "encoder": {"joint": _TEXT, "file": _TEXT, "angle_noise_std": _number("rad"), "zero": _number("rad")},
    "pose": {"segment": _TEXT, "file": _TEXT, "position_noise_std": _number("m"), "rotation_noise_std": _number("rad")},
    "free_swing": {"start": _number("s", required=True), "end": _number("s", required=True)},
    "body": {
        "mass": _number("kg", required=True),
        "com": _vector("m", required=True),
        "inertia": _vector("kg m^2", required=True),
    },
    "reference": {"file": _TEXT},
}
LISTS = ("imu", "encoder", "pose", "free_swing")  # tables that may come more than once


@dataclass(frozen=True)
class Declared:
    """The checked content of one recording.toml; numbers are floats."""

    path: Path
    top: Mapping[str, Any]
    tables: Mapping[str, list[Mapping[str, Any]]]  # by kind; those of `LISTS` any number, the others at most one

    def file(self, text: str, where: str) -> Path:
        """Return the path of a file beside recording.toml; `InputError` for one that leads elsewhere."""
        return below(self.path.parent, text, f"{self.path}, {where}", "a file below the recording's folder")


def read_declared(folder: Path) -> Declared:
    """Return what recording.toml in `folder` declares, every key known and of its type.

    Raises `InputError` with file and key, or line for what is no TOML.
    """
    folder = Path(folder)
    path = folder / FILE_NAME
    if what_is(path) == NOTHING:
        got = "one without" if what_is(folder) == "a folder" else what_is(folder)
        raise InputError(f"{folder}: expected a folder with {FILE_NAME}, got {got}")
    content = load_toml(path)
    version = content.get("format", FORMAT)
    if type(version) is not int or version != FORMAT:  # first: the keys of another format may be others
        raise InputError(f"{path}, key 'format': expected {FORMAT}, got {describe(version)}")
    top = {key: value for key, value in content.items() if key not in KEYS or not key}
    tables = {kind: _entries(path, kind, content.get(kind)) for kind in KEYS if kind}
    return Declared(
        path,
        _checked(path, "", top, "", [*KEYS[""], *tables]),
        {
            kind: [
                _checked(path, kind, entry, f"{title(kind, i)}, ", list(KEYS[kind])) for i, entry in enumerate(entries)
            ]
            for kind, entries in tables.items()
        },
    )


def title(kind: str, index: int) -> str:
    """Return how a table is named in messages: `[[imu]] number 2`, `[body]`."""
    return f"[[{kind}]] number {index + 1}" if kind in LISTS else f"[{kind}]"


def describe(value: object) -> str:
    """Return a value of a TOML file as a message shows it, with its kind."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, date | time):
        return f"a date or time {value}"
    kind = {bool: "", str: "text ", list: "list "}.get(type(value), "")
    return kind + (str(value).lower() if isinstance(value, bool) else shown(value))


def _entries(path: Path, kind: str, value: object) -> list[Mapping[str, Any]]:
    """Return the tables of one kind; `[imu]` for `[[imu]]`, and the reverse, is an error."""
    if value is None:
        return []
    if kind in LISTS:
        if isinstance(value, list) and all(isinstance(entry, dict) for entry in value):
            return value
        raise InputError(f"{path}, key '{kind}': expected tables [[{kind}]], got {describe(value)}")
    if isinstance(value, dict):
        return [value]
    raise InputError(f"{path}, key '{kind}': expected one table [{kind}], got {describe(value)}")


def _checked(path: Path, kind: str, entry: Mapping[str, Any], where: str, known: list[str]) -> dict[str, Any]:
    """Return an entry with numbers as floats; `InputError` for an unknown or missing key, or a wrong type."""
    for key in entry:
        if key not in KEYS[kind]:
            raise InputError(f"{path}, {where}{unknown('key', key, known)}")
    for key, want in KEYS[kind].items():
        if want.required and key not in entry:
            raise InputError(f"{path}, {where}key '{key}': expected {want}, got no such key")
    return {key: _value(f"{path}, {where}key '{key}'", KEYS[kind][key], key, value) for key, value in entry.items()}


def _value(where: str, want: Key, key: str, value: object) -> object:
    if want.size:
        if not isinstance(value, list) or len(value) != want.size or not all(map(_is_number, value)):
            raise InputError(f"{where}: expected {want}, got {describe(value)}")
        return [_value(where, Key(want.kind, want.unit), key, item) for item in value]
    fits = {"text": isinstance(value, str), "integer": type(value) is int, "number": _is_number(value)}
    if not fits[want.kind]:
        raise InputError(f"{where}: expected {want}, got {describe(value)}")
    if want.kind != "number":
        return value
    try:
        number = float(value)  # type: ignore[arg-type]
    except OverflowError:
        number = float("inf")
    if not isfinite(number) or (key.endswith("_std") and number < 0):
        raise InputError(f"{where}: expected a finite number{' >= 0' * key.endswith('_std')}, got {describe(value)}")
    return number


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
