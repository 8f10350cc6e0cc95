"""The `model/` of a diagnosis, read back: the rig, its motion, the sensors and what was found at them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.correction.export import CHANNEL_COLUMNS, MODEL_FORMAT, PLAY_COLUMNS, SENSORS_FILE
from imubench.correction.rig_file import read_rig
from imubench.correction.sensor_chain import Effects, Link, at_encoder, at_place, chained
from imubench.correction.swing_file import KEY, read_swings
from imubench.diagnosis.config.correction import READ_MODEL
from imubench.diagnosis.evidence import Played, Swing
from imubench.diagnosis.problem.bspline import DEGREE
from imubench.diagnosis.result import UNKNOWN
from imubench.effects import EFFECTS
from imubench.errors import InputError, shown, unknown
from imubench.inputs.files import inside
from imubench.inputs.tables import read_table
from imubench.inputs.toml import load_toml
from imubench.sim.rigs import Rig

FORCE_COLUMNS, POSITION_COLUMNS, ROTATION_COLUMNS = (
    ("force_x", "force_y", "force_z"),
    ("x", "y", "z"),
    ("qw", "qx", "qy", "qz"),
)
PARAMETER_RANGES = {
    "cutoff": (1e-3, 1e6), "step": (1e-9, 1e6), "limit": (0.0, 1e9), "std": (0.0, 1e9), "fraction": (0.0, 0.9),
    "range": (0.0, np.pi), "skew": (-0.5, 0.5), "times": (-1e9, 1e9),
}  # fmt: skip
"""What numbers of an effect can be: Hz, the sensor's unit, a share, rad, 1, s. Beyond, its law divides by nothing."""


@dataclass(frozen=True)
class Sampling:
    """One sensor of a model: when it samples, and how noisy it is."""

    stamps: Array  # (n,) s
    rate: float  # Hz, nominal
    noise: tuple[float, ...]  # std of a sample: rad/s and m/s^2 of an IMU, rad of an encoder


@dataclass(frozen=True)
class Model:
    """A diagnosis' simulation."""

    recording: str  # the name of what was diagnosed
    rig: Rig
    motion: Played
    start: float  # s, the stamp that counts as zero
    imus: Mapping[str, Sampling]
    encoders: Mapping[str, Sampling]  # by joint
    effects: Effects
    swings: tuple[Swing, ...] = ()  # that are rolled out

    @property
    def end(self) -> float:
        """The last stamp in s."""
        return max(float(s.stamps[-1]) for s in (*self.imus.values(), *self.encoders.values()))

    def chain(self, imu: str) -> tuple[Link, ...]:
        """Return the effects at an IMU."""
        return at_place(self.effects, imu)


def read_model(folder: Path) -> Model:
    """Return the simulation in a `model/` folder.

    Args:
        folder: the folder.

    Raises:
        InputError: a file is missing, damaged, leads out of the folder, is beyond the limits, or says what cannot be.
    """
    folder = Path(folder)
    path = folder / SENSORS_FILE
    content = load_toml(path)
    if content.get("format") != MODEL_FORMAT:
        raise InputError(f"{path}: expected format = {MODEL_FORMAT}, got {shown(content.get('format'))}")
    family, told = text(content, "rig", str(path)), text(content, "recording", str(path))
    model, path_of_motion = (inside(folder, text(content, key, str(path)), str(path)) for key in ("model", "motion"))
    rig, motion = read_rig(model, family), read_motion(path_of_motion)
    imus: dict[str, Sampling] = {}
    known = [f"imu{i + 1}" for i in range(len(rig.mounts))]
    for i, table in enumerate(tables(content, "imu", path)):
        where = f"{path}, imu[{i}]"
        name = text(table, "name", where)
        if name not in known or name in imus:
            raise unknown(f"imu of a {family} in {path}", name, [n for n in known if n not in imus])
        imus[name] = _sampling(table, ("gyro_noise_std", "accel_noise_std"), where)
    encoders = {}
    for i, table in enumerate(tables(content, "encoder", path)):
        where = f"{path}, encoder[{i}]"
        encoders[text(table, "joint", where)] = _sampling(table, ("angle_noise_std",), where)
    if not imus and not encoders:
        raise InputError(f"{path}: expected an [[imu]] or an [[encoder]], got none")
    effects = tuple(
        _effect(table, f"{path}, effect[{i}]", folder) for i, table in enumerate(tables(content, "effect", path))
    )
    first = min(float(s.stamps[0]) for s in (*imus.values(), *encoders.values()))
    start = _start(content, first, str(path))
    found = Model(told, rig, motion, start, imus, encoders, effects)
    if found.start < motion.time[0] - READ_MODEL.edge_s or found.end > motion.time[-1] + READ_MODEL.edge_s:
        raise InputError(
            f"{path_of_motion}: expected a motion over the samples' {found.start:g} to {found.end:g} s, got one over "
            f"{motion.time[0]:g} to {motion.time[-1]:g} s"
        )
    swings = read_swings(tables(content, KEY, path), family, (found.start, found.end), str(path))
    return replace(found, swings=swings)


def _sampling(table: Mapping[str, Any], noises: tuple[str, ...], where: str) -> Sampling:
    noise = tuple(_number(table, key, where) for key in noises)
    return Sampling(_stamps(table, where), float(_number(table, "rate", where)), noise)


def _start(content: Mapping[str, Any], first: float, where: str) -> float:
    """Return the time in s that counts as zero: the first sample's, or an earlier one that is told."""
    told = content.get("start", first)
    if not isinstance(told, int | float) or isinstance(told, bool) or not first - READ_MODEL.most_s <= told <= first:
        raise InputError(
            f"{where}, key 'start': expected a time in s up to the first sample's {first:g}, got {shown(told)}"
        )
    return float(told)


def _effect(table: Mapping[str, Any], where: str, folder: Path) -> tuple[str, Link]:
    """Return an effect's place, and the effect: its numbers as its law has them, settings, a signal."""
    name, at = text(table, "name", where), text(table, "at", where)
    values = _parameters(table, where)
    for key, width in (widths(name) if chained(name) else {}).items():
        if key in values and values[key].size != width:
            raise InputError(f"{where}, key 'parameters.{key}': expected {width} of {name}, got {values[key].size}")
    for key, (low, high) in PARAMETER_RANGES.items() if chained(name) or at_encoder(name) else ():
        if key in values and not ((values[key] >= low) & (values[key] <= high)).all():
            got = values[key].tolist()
            raise InputError(f"{where}, key 'parameters.{key}': expected numbers from {low:g} to {high:g}, got {got}")
    if name == UNKNOWN:
        time, signals = _signal(table, where, folder) if table.get("replayed") else (np.zeros(0), {})
        return at, Link(name, {}, {}, time, signals)
    link = Link(name, values, _settings(table, where))
    if (chained(name) or at_encoder(name)) and not needed(link) <= set(values):
        missing = sorted(needed(link) - set(values))[0]
        raise InputError(f"{where}, key 'parameters': expected '{missing}' of {name}, got none")
    return at, link


def widths(name: str) -> dict[str, int]:
    """Return how many numbers each parameter of an effect is, where that is the same in every recording."""
    effect = EFFECTS.get(name)
    if effect is None:
        return {}
    found = {f.name: int(np.prod([n or 0 for n in f.shape], dtype=int)) for f in effect.found if None not in f.shape}
    return found | {p.name: p.width for p in effect.parameters}


def needed(link: Link) -> set[str]:
    """Return the numbers without which an effect at an IMU cannot be played."""
    effect = EFFECTS[link.effect]
    return {f.name for f in effect.found} or {p.name for p in effect.parameters if p.reported}


def _settings(table: Mapping[str, Any], where: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, known in (("channels", ("gyro", "accel")), ("mode", ("missing", "held"))):
        if key in table:
            given = table[key] if isinstance(table[key], list) else [table[key]]
            for one in given:
                if one not in known:
                    raise unknown(f"{where}, key '{key}'", str(one), known)
            found[key] = tuple(given) if key == "channels" else given[0]
    return found


def _signal(table: Mapping[str, Any], where: str, folder: Path) -> tuple[Array, dict[str, Array]]:
    """Return times (n,) s since the start and what a sensor reads besides, (n, 3) by part."""
    path = inside(folder, text(table, "signal", where), where)
    read = read_table(path, ("time",), tuple(name for names in CHANNEL_COLUMNS.values() for name in names))
    signals = {part: read.stack(names) for part, names in CHANNEL_COLUMNS.items() if set(names) <= set(read.columns)}
    return read.columns["time"], signals


def tables(content: Mapping[str, Any], key: str, path: Path) -> list[dict[str, Any]]:
    """Return the `[[key]]` tables of a file; none where it has none."""
    found = content.get(key, [])
    if not isinstance(found, list) or not all(isinstance(table, dict) for table in found):
        raise InputError(f"{path}, key '{key}': expected [[{key}]] tables, got {shown(found)}")
    return found


def text(table: Mapping[str, Any], key: str, where: str) -> str:
    """Return a text of a table; `InputError` where it is none."""
    value = table.get(key)
    if not isinstance(value, str):
        raise InputError(f"{where}, key '{key}': expected a text, got {shown(value)}")
    return value


def _number(table: Mapping[str, Any], key: str, where: str) -> float:
    """Return a number of a table from 0 on; readers let none that is not finite pass."""
    value = table.get(key)
    if not isinstance(value, int | float) or isinstance(value, bool) or value < 0:
        raise InputError(f"{where}, key '{key}': expected a number >= 0, got {shown(value)}")
    return float(value)


def _stamps(table: Mapping[str, Any], where: str) -> Array:
    """Return the stamps (n,) s of a sensor that samples evenly."""
    samples, start, rate = table.get("samples"), table.get("start"), _number(table, "rate", where)
    if not isinstance(samples, int) or isinstance(samples, bool) or not 2 <= samples <= READ_MODEL.most_samples:
        raise InputError(
            f"{where}, key 'samples': expected 2 to {READ_MODEL.most_samples:,} samples, got {shown(samples)}"
        )
    if not isinstance(start, int | float) or isinstance(start, bool):
        raise InputError(f"{where}, key 'start': expected a number in s, got {shown(start)}")
    if not READ_MODEL.least_rate_hz <= rate <= READ_MODEL.most_rate_hz or samples / rate > READ_MODEL.most_s:
        raise InputError(
            f"{where}, key 'rate': expected {READ_MODEL.least_rate_hz:g} to {READ_MODEL.most_rate_hz:g} Hz "
            f"and at most {READ_MODEL.most_s:g} s of samples, got {rate:g} Hz and {samples:,} samples"
        )
    if "end" in table:  # of what lost samples: those are lost anew
        end = table["end"]
        most = start + READ_MODEL.most_s
        if not isinstance(end, int | float) or isinstance(end, bool) or not start < end <= most:
            raise InputError(f"{where}, key 'end': expected a time in s from {start:g} to {most:g}, got {shown(end)}")
        if (samples - 1) / (end - start) > READ_MODEL.most_rate_hz:
            raise InputError(
                f"{where}, key 'end': expected at most {READ_MODEL.most_rate_hz:g} Hz, "
                f"got {samples:,} samples by {end:g} s"
            )
        # a clock may be a little quick
        samples = min(max(round((end - start) * rate) + 1, samples), READ_MODEL.most_samples)
        return np.linspace(start, end, samples)
    return np.asarray(start + np.arange(samples) / rate, dtype=float)


def _parameters(table: Mapping[str, Any], where: str) -> dict[str, Array]:
    """Return the parameters of an effect, each as an array of one dimension or more."""
    given = table.get("parameters")
    if not isinstance(given, dict):
        raise InputError(f"{where}, key 'parameters': expected a table, got {shown(given)}")
    found = {}
    for key, value in given.items():
        try:
            found[key] = np.atleast_1d(np.asarray(value, dtype=float))
        except (TypeError, ValueError):
            raise InputError(f"{where}, key 'parameters.{key}': expected numbers, got {shown(value)}") from None
    return found


def read_motion(path: Path) -> Played:
    """Return the motion in motion.csv."""
    table = read_table(
        path, ("time", *ROTATION_COLUMNS), (*FORCE_COLUMNS, *POSITION_COLUMNS, "hinge_angle", *PLAY_COLUMNS)
    )
    time = table.columns["time"]
    if time.size <= DEGREE:
        raise InputError(f"{path}: expected {DEGREE + 1} rows or more, got {time.size}")
    has = [name for name in (*FORCE_COLUMNS, *POSITION_COLUMNS, *PLAY_COLUMNS) if name in table.columns]
    place = table.stack(POSITION_COLUMNS) if set(POSITION_COLUMNS) <= set(has) else np.zeros((time.size, 3))
    force = table.stack(FORCE_COLUMNS) if set(FORCE_COLUMNS) <= set(has) else None
    across = table.stack(PLAY_COLUMNS).T if set(PLAY_COLUMNS) <= set(has) else None
    return Played(time, table.stack(ROTATION_COLUMNS), place, table.columns.get("hinge_angle"), force, play=across)


__all__ = ["Model", "Sampling", "read_model", "read_motion", "tables", "text"]
