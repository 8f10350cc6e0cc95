"""IMU profiles as data: profiles.toml, every number with its unit and its source.

A table is a profile. Its numbers are inline tables ``{ value, unit, source, note }``; `unit` must be one of
`UNITS` for that number, `source` names the datasheet, the paper, or says that the number is in neither.
"""

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError, unknown
from imubench.inputs.toml import load_toml, parse_toml
from imubench.sim.imu_profile import ChannelProfile, ImuProfile

G = 9.80665  # m/s^2, the unit g
DEG = np.pi / 180

Units = Mapping[str, float]  # name -> what one of it is in SI
PLAIN: Units = {"1": 1.0, "%": 1e-2, "ppm": 1e-6}
SECONDS: Units = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
HERTZ: Units = {"Hz": 1.0, "kHz": 1e3}
ANGULAR_RATE: Units = {"rad/s": 1.0, "deg/s": DEG, "deg/h": DEG / 3600}
SPECIFIC_FORCE: Units = {"m/s^2": 1.0, "g": G, "mg": 1e-3 * G, "ug": 1e-6 * G}


def _per(units: Units, divisor: str) -> Units:
    """Return `units` with `/divisor` appended to each name; the divisor is SI."""
    return {f"{name}/{divisor}": value for name, value in units.items()}


def _channel_units(unit: Units) -> Mapping[str, Units]:
    return {
        "noise_density": _per(unit, "sqrt(Hz)"),
        "noise_std": unit,
        "bias": unit,
        "bias_std": unit,
        "bias_random_walk": _per(unit, "s/sqrt(Hz)"),
        "bias_instability": unit,
        "bias_correlation_time": SECONDS,
        "scale": PLAIN,
        "scale_std": PLAIN,
        "misalignment": PLAIN,
        "misalignment_std": PLAIN,
        "range": unit,
        "step": unit,
        "bandwidth": HERTZ,
    }


UNITS: Mapping[str, Mapping[str, Units]] = {
    "": {
        "rate": HERTZ,
        "g_sensitivity": {"rad/s/(m/s^2)": 1.0, "deg/s/g": DEG / G},
        "jitter_std": SECONDS,
        "clock_offset": SECONDS,
        "clock_skew": PLAIN,
        "dropout_fraction": PLAIN,
    },
    "gyro": _channel_units(ANGULAR_RATE),
    "accel": _channel_units(SPECIFIC_FORCE),
}
"""The numbers of a profile ("") and of its channels, each with the units it may come in."""

TEXTS = ("summary", "dropout_mode")


def profile(name: str) -> ImuProfile:
    """Return a profile that comes with the project; `InputError` names the known ones."""
    if name not in PROFILES:
        raise unknown("IMU profile", name, PROFILES)
    return PROFILES[name]


def load_profiles(path: Path) -> Mapping[str, ImuProfile]:
    """Return the profiles of a TOML file of your own by name; `InputError` says what is wrong with it."""
    return _parse_profiles(load_toml(path), str(path))


def parse_profiles(content: bytes, where: str) -> Mapping[str, ImuProfile]:
    """Return the profiles in the bytes of a TOML file by name.

    Raises `InputError` for anything but UTF-8 TOML, an unknown key or unit, a number without a source, or a
    number that `ImuProfile` refuses.
    """
    return _parse_profiles(parse_toml(content, where), where)


def _parse_profiles(tables: Mapping[str, Any], where: str) -> Mapping[str, ImuProfile]:
    return {name: _parse_profile(name, _table(table, f"{where}: {name}"), where) for name, table in tables.items()}


def _parse_profile(name: str, table: Mapping[str, Any], where: str) -> ImuProfile:
    here = f"{where}: {name}"
    sources: dict[str, str] = {}
    texts = {key: table[key] for key in TEXTS if key in table}
    for key, text in texts.items():
        if not isinstance(text, str):
            raise InputError(f"{here}.{key}: expected a text, got {text!r}")
    for key in table:
        if key not in (*UNITS[""], *TEXTS, "gyro", "accel"):
            raise unknown(f"key in {here}", key, (*UNITS[""], *TEXTS, "gyro", "accel"))
    if "rate" not in table:
        raise InputError(f"{here}.rate: expected a rate, got none")
    numbers = _parse_numbers({k: v for k, v in table.items() if k in UNITS[""]}, "", here, sources)
    gyro, accel = (_parse_channel(table.get(kind, {}), kind, here, sources) for kind in ("gyro", "accel"))
    try:
        return ImuProfile(name=name, gyro=gyro, accel=accel, sources=sources, **numbers, **texts)
    except InputError as error:
        raise InputError(f"{here}: {error}") from None


def _parse_channel(table: object, kind: str, here: str, sources: dict[str, str]) -> ChannelProfile:
    numbers = _parse_numbers(_table(table, f"{here}.{kind}"), kind, here, sources)
    try:
        return ChannelProfile(**numbers)
    except InputError as error:
        raise InputError(f"{here}: {kind}: {error}") from None


def _parse_numbers(table: Mapping[str, Any], kind: str, here: str, sources: dict[str, str]) -> dict[str, Any]:
    """Return the numbers of one table in SI, and add where each comes from to `sources`."""
    numbers: dict[str, Any] = {}
    for key, entry in table.items():
        path = f"{kind}.{key}" if kind else key
        if key not in UNITS[kind]:
            raise unknown(f"key in {here}.{kind}", key, UNITS[kind])
        numbers[key] = _parse_number(_table(entry, f"{here}.{path}"), UNITS[kind][key], f"{here}.{path}")
        sources[path] = "; ".join(entry[part] for part in ("source", "note") if part in entry)
    return numbers


def _parse_number(entry: Mapping[str, Any], units: Units, here: str) -> float | Array:
    """Return one number, or array of them, in SI."""
    for key in entry:
        if key not in ("value", "unit", "source", "note"):
            raise unknown(f"key in {here}", key, ("value", "unit", "source", "note"))
    for key in ("source", "unit"):
        if not isinstance(entry.get(key), str) or not entry[key].strip():
            raise InputError(f"{here}.{key}: expected a text, got {entry.get(key)!r}")
    if not isinstance(entry.get("note", ""), str):
        raise InputError(f"{here}.note: expected a text, got {entry['note']!r}")
    if entry["unit"] not in units:
        raise unknown(f"unit of {here}", entry["unit"], units)
    given = entry.get("value")
    try:
        value = np.array(given if given is not None else "nothing", dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{here}.value: expected a number or a list of them, got {given!r}") from None
    if not np.isfinite(value).all():
        raise InputError(f"{here}.value: expected finite numbers, got {given!r}")
    scaled = value * units[entry["unit"]]
    return scaled if scaled.ndim else float(scaled)


def _table(value: object, here: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{here}: expected a table, got {value!r}")
    return value


PROFILES = parse_profiles((files("imubench.sim") / "profiles.toml").read_bytes(), "profiles.toml")
"""The profiles that come with the project, by name."""
