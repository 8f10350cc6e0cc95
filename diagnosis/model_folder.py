"""The `model/` of a diagnosis, read back and played: MJCF, sensors, effects and motion become a recording.

Inside its free swings the rig is rolled out by forces alone; elsewhere the recovered motion is prescribed.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.evidence import Played
from imubench.diagnosis.export import FORMAT, SENSORS, sensor_law
from imubench.diagnosis.replay import DEGREE, played_through, readings
from imubench.diagnosis.rig_file import read_rig
from imubench.diagnosis.simulation.splice import with_swings
from imubench.diagnosis.simulation.swing_file import KEY, read_swings
from imubench.effects.effect import Reading
from imubench.errors import InputError, shown, unknown
from imubench.inputs.files import inside
from imubench.inputs.tables import read_table
from imubench.inputs.toml import load_toml
from imubench.jets import Jet
from imubench.recording import Encoder, Imu, Recording
from imubench.truth import Truth

FORCE, PLACE, TURN = ("force_x", "force_y", "force_z"), ("x", "y", "z"), ("qw", "qx", "qy", "qz")
MOST_SAMPLES = 2_000_000  # of a sensor: what fits into a gigabyte while MuJoCo plays it
LEAST_RATE, MOST_RATE = 0.1, 10_000.0  # Hz, of inertial sensors and encoders
MOST_SECONDS = 5_000.0  # of a recording: 2 million states at 400 Hz, the least that is played
EDGE = 0.5  # s by which samples may go on beyond the motion's first and last row


def is_model(folder: Path) -> bool:
    """Return whether a folder is a diagnosis' model."""
    return (Path(folder) / SENSORS).is_file()


def check_same(folder: Path, recording: Recording) -> None:
    """Raise `InputError` where a `model/` folder, if it is one, was made from other samples than a recording's."""
    if not is_model(folder):
        return
    path = folder / SENSORS
    for i, table in enumerate(tables_of(load_toml(path), "imu", path)):
        where = f"{path}, imu[{i}]"
        name, imus = _text(table, "name", where), {i.name: i for i in recording.imus}
        if name not in imus:
            raise unknown("imu of the diagnosis", name, imus)
        told, time = (table.get("samples"), table.get("start")), imus[name].time
        if told != (time.size, float(time[0])):
            raise InputError(
                f"{path}: expected {name} of {recording.name} with {time.size} samples from "
                f"{time[0]:g} s on, got {shown(told[0])} from {shown(told[1])} s on: the diagnosis of another recording"
            )


def replay(folder: Path, rng: np.random.Generator) -> tuple[Recording, Truth]:
    """Return what the IMUs of a `model/` folder record while MuJoCo plays its motion, and the truth of it.

    Args:
        folder: the folder.
        rng: noise is drawn from it.

    Raises:
        InputError: a file is missing, damaged, leads out of the folder, is beyond the limits, or says what cannot be.
    """
    folder = Path(folder)
    path = folder / SENSORS
    content = load_toml(path)
    if content.get("format") != FORMAT:
        raise InputError(f"{path}: expected format = {FORMAT}, got {shown(content.get('format'))}")
    family, told = _text(content, "rig", str(path)), _text(content, "recording", str(path))
    model, path_of_motion = (inside(folder, _text(content, key, str(path)), str(path)) for key in ("model", "motion"))
    rig = read_rig(model, family)
    motion = read_motion(path_of_motion)
    imus, encoders = (tables_of(content, key, path) for key in ("imu", "encoder"))
    stamps: dict[str, Array] = {}
    noise: dict[str, tuple[float, float]] = {}
    known = [f"imu{i + 1}" for i in range(len(rig.mounts))]
    for i, table in enumerate(imus):
        where = f"{path}, imu[{i}]"
        name = _text(table, "name", where)
        if name not in known or name in stamps:
            raise unknown(f"imu of a {family} in {path}", name, [n for n in known if n not in stamps])
        stamps[name] = _stamps(table, where)
        noise[name] = (_number(table, "gyro_noise_std", where), _number(table, "accel_noise_std", where))
    for i, table in enumerate(encoders):
        where = f"{path}, encoder[{i}]"
        stamps[_text(table, "joint", where)] = _stamps(table, where)
    angle_noise = [_number(e, "angle_noise_std", f"{path}, encoder[{i}]") for i, e in enumerate(encoders)]
    effects = effects_of(content, path)
    if not stamps:
        raise InputError(f"{path}: expected an [[imu]] or an [[encoder]], got none")
    start, end = min(t[0] for t in stamps.values()), max(t[-1] for t in stamps.values())
    if start < motion.time[0] - EDGE or end > motion.time[-1] + EDGE:
        raise InputError(
            f"{path_of_motion}: expected a motion over the samples' {start:g} to {end:g} s, got one over "
            f"{motion.time[0]:g} to {motion.time[-1]:g} s"
        )
    truth = played_through(rig, motion, start, end - start, max(float(s["rate"]) for s in (*imus, *encoders)))
    swings = read_swings(tables_of(content, KEY, path), family, (start, end), str(path))
    truth = with_swings(rig, truth, start, swings)
    made = []
    for table in imus:
        name = table["name"]
        mount = rig.mounts[int(name[-1]) - 1]
        own = {effect: values for (effect, at), values in effects.items() if at == name}
        gyro, accel = reported(truth, start, stamps[name], name, own)
        gyro, accel = (x + s * rng.standard_normal(x.shape) for x, s in zip((gyro, accel), noise[name], strict=True))
        pose = mount.position, mount.quaternion
        made.append(Imu(name, stamps[name], gyro, accel, table["rate"], *noise[name], None, None, *pose))
    recording = Recording(
        told,
        family,
        tuple(made),
        encoders=tuple(
            _encoder(truth, start, e["joint"], stamps[e["joint"]], std, rng)
            for e, std in zip(encoders, angle_noise, strict=True)
        ),
        gravity=rig.gravity,
        base=rig.base,
        base_quaternion=rig.base_quaternion,
    )
    return recording, truth


def effects_of(content: Mapping[str, Any], path: Path) -> dict[tuple[str, str], dict[str, Array]]:
    """Return the parameters of every effect in the content of imus.toml, by effect and place."""
    effects = {}
    for i, table in enumerate(tables_of(content, "effect", path)):
        where = f"{path}, effect[{i}]"
        effect = _text(table, "name", where)
        effects[effect, _text(table, "at", where)] = values = _parameters(table, where)
        law = sensor_law(effect, values)
        for p in law.parameters if law else ():
            if values[p.name].size != p.width:
                got = values[p.name].size
                raise InputError(f"{where}, key 'parameters.{p.name}': expected {p.width} of {effect}, got {got}")
    return effects


def tables_of(content: Mapping[str, Any], key: str, path: Path) -> list[dict[str, Any]]:
    """Return the [[key]] tables in the content of imus.toml; none where there are none."""
    found = content.get(key, [])
    if not isinstance(found, list) or not all(isinstance(table, dict) for table in found):
        raise InputError(f"{path}, key '{key}': expected [[{key}]] tables, got {shown(found)}")
    return found


def _text(table: Mapping[str, Any], key: str, where: str) -> str:
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
    if not isinstance(samples, int) or isinstance(samples, bool) or not 2 <= samples <= MOST_SAMPLES:
        raise InputError(f"{where}, key 'samples': expected 2 to {MOST_SAMPLES:,} samples, got {shown(samples)}")
    if not isinstance(start, int | float) or isinstance(start, bool):
        raise InputError(f"{where}, key 'start': expected a number in s, got {shown(start)}")
    if not LEAST_RATE <= rate <= MOST_RATE or samples / rate > MOST_SECONDS:
        raise InputError(
            f"{where}, key 'rate': expected {LEAST_RATE:g} to {MOST_RATE:g} Hz and at most {MOST_SECONDS:g} s of "
            f"samples, got {rate:g} Hz and {samples:,} samples"
        )
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


def _encoder(truth: Truth, start: float, joint: str, stamps: Array, std: float, rng: np.random.Generator) -> Encoder:
    if truth.joint_angle is None:
        raise InputError(f"encoder {joint}: expected a hinge rig, got '{truth.rig}'")
    angle = np.interp(stamps - start, truth.time, truth.joint_angle)
    return Encoder(joint, stamps, angle + std * rng.standard_normal(stamps.size), std)


def reported(
    truth: Truth,
    start: float,
    stamps: Array,
    name: str,
    effects: Mapping[str, Mapping[str, Array]],
    first: float = 0.0,
) -> tuple[Array, Array]:
    """Return rate and specific force (n, 3) as an IMU reports them, its clock and its errors in.

    Drifts and clocks count from `start`, a stamp in s; the first row of the truth is `first` s behind it.
    """
    laws = [(sensor_law(effect, values), values) for effect, values in effects.items()]
    known = [(law, {k: Jet(v.reshape(1, -1)) for k, v in values.items()}) for law, values in laws if law is not None]
    time = Jet((stamps - start)[:, None])
    for law, values in known:
        time = law.clock(time, values)
    gyro, accel = readings(truth, first, {name: np.clip(time.value[:, 0], first, first + truth.time[-1])})[name]
    reading = Reading(Jet(gyro), Jet(accel), time)
    for law, values in known:
        error = law.error(reading, values)
        gyro = gyro if error.gyro is None else gyro + error.gyro.value
        accel = accel if error.accel is None else accel + error.accel.value
    return gyro, accel


def read_motion(path: Path) -> Played:
    """Return the motion in motion.csv."""
    table = read_table(path, ("time", *TURN), (*FORCE, *PLACE, "hinge_angle"))
    time = table.columns["time"]
    if time.size <= DEGREE:
        raise InputError(f"{path}: expected {DEGREE + 1} rows or more, got {time.size}")
    has = [name for name in (*FORCE, *PLACE, "hinge_angle") if name in table.columns]
    place = table.stack(PLACE) if set(PLACE) <= set(has) else np.zeros((time.size, 3))
    force = table.stack(FORCE) if set(FORCE) <= set(has) else None
    return Played(time, table.stack(TURN), place, table.columns.get("hinge_angle"), force)
