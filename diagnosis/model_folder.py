"""The `model/` of a diagnosis, read back and played: MJCF, sensors, effects and motion become a recording."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.evidence import Played
from imubench.diagnosis.export import FORMAT, SENSORS, sensor_law
from imubench.diagnosis.replay import played_through, readings
from imubench.diagnosis.rig_file import read_rig
from imubench.effects.effect import Reading
from imubench.errors import InputError, unknown
from imubench.inputs.tables import read_table
from imubench.inputs.toml import load_toml
from imubench.jets import Jet
from imubench.recording import Encoder, Imu, Recording
from imubench.truth import Truth

FORCE, PLACE, TURN = ("force_x", "force_y", "force_z"), ("x", "y", "z"), ("qw", "qx", "qy", "qz")


def is_model(folder: Path) -> bool:
    """Return whether a folder is a diagnosis' model."""
    return (Path(folder) / SENSORS).is_file()


def check_same(folder: Path, recording: Recording) -> None:
    """Raise `InputError` where a `model/` folder, if it is one, was made from other samples than a recording's."""
    if not is_model(folder):
        return
    content = load_toml(folder / SENSORS)
    for table in content.get("imu", []):
        name, imus = table.get("name"), {i.name: i for i in recording.imus}
        if name not in imus:
            raise unknown("imu of the diagnosis", name, imus)
        told, time = (table.get("samples"), table.get("start")), imus[name].time
        if told != (time.size, float(time[0])):
            raise InputError(
                f"{folder / SENSORS}: expected {name} of {recording.name} with {time.size} samples from "
                f"{time[0]:g} s on, got {told[0]} from {told[1]} s on: the diagnosis of another recording"
            )


def replay(folder: Path, rng: np.random.Generator) -> tuple[Recording, Truth]:
    """Return what the IMUs of a `model/` folder record while MuJoCo plays its motion, and the truth of it.

    Noise is drawn from `rng`. Raises `InputError` for a file that is missing or says what cannot be.
    """
    folder = Path(folder)
    content = load_toml(folder / SENSORS)
    if content.get("format") != FORMAT:
        raise InputError(f"{folder / SENSORS}: expected format = {FORMAT}, got {content.get('format')!r}")
    for key in ("rig", "recording", "model", "motion"):
        if key not in content:
            raise InputError(f"{folder / SENSORS}: expected a key '{key}', got none")
    rig = read_rig(folder / content["model"], content["rig"])
    motion = read_motion(folder / content["motion"])
    imus, encoders = content.get("imu", []), content.get("encoder", [])
    try:
        stamps = {s["name" if s in imus else "joint"]: _stamps(s) for s in (*imus, *encoders)}
        noise = {i["name"]: (float(i["gyro_noise_std"]), float(i["accel_noise_std"])) for i in imus}
        angle_noise = [float(e["angle_noise_std"]) for e in encoders]
        effects = {
            (e["name"], e["at"]): {k: np.atleast_1d(np.asarray(v, dtype=float)) for k, v in e["parameters"].items()}
            for e in content.get("effect", [])
        }
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{folder / SENSORS}: expected whole tables of sensors and effects, got: {error}") from None
    if not stamps:
        raise InputError(f"{folder / SENSORS}: expected an [[imu]] or an [[encoder]], got none")
    start, end = min(t[0] for t in stamps.values()), max(t[-1] for t in stamps.values())
    truth = played_through(rig, motion, start, end - start, max(float(s["rate"]) for s in (*imus, *encoders)))
    made = []
    for i in imus:
        name = i["name"]
        mount = rig.mounts[int(name[-1]) - 1]
        own = {effect: values for (effect, at), values in effects.items() if at == name}
        gyro, accel = reported(truth, start, stamps[name], name, own)
        gyro, accel = (x + s * rng.standard_normal(x.shape) for x, s in zip((gyro, accel), noise[name], strict=True))
        pose = mount.position, mount.quaternion
        made.append(Imu(name, stamps[name], gyro, accel, i["rate"], *noise[name], None, None, *pose))
    recording = Recording(
        content["recording"],
        content["rig"],
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


def _stamps(table: Mapping[str, Any]) -> Array:
    return np.asarray(table["start"] + np.arange(table["samples"]) / table["rate"], dtype=float)


def _encoder(truth: Truth, start: float, joint: str, stamps: Array, std: float, rng: np.random.Generator) -> Encoder:
    if truth.joint_angle is None:
        raise InputError(f"encoder {joint}: expected a hinge rig, got '{truth.rig}'")
    angle = np.interp(stamps - start, truth.time, truth.joint_angle)
    return Encoder(joint, stamps, angle + std * rng.standard_normal(stamps.size), std)


def reported(
    truth: Truth, start: float, stamps: Array, name: str, effects: Mapping[str, Mapping[str, Array]]
) -> tuple[Array, Array]:
    """Return rate and specific force (n, 3) as an IMU reports them, its clock and its errors in."""
    laws = [(sensor_law(effect, values), values) for effect, values in effects.items()]
    known = [(law, {k: Jet(v.reshape(1, -1)) for k, v in values.items()}) for law, values in laws if law is not None]
    time = Jet((stamps - start)[:, None])
    for law, values in known:
        time = law.clock(time, values)
    gyro, accel = readings(truth, 0.0, {name: np.clip(time.value[:, 0], 0.0, truth.time[-1])})[name]
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
    has = [name for name in (*FORCE, *PLACE, "hinge_angle") if name in table.columns]
    place = table.stack(PLACE) if set(PLACE) <= set(has) else np.zeros((time.size, 3))
    force = table.stack(FORCE) if set(FORCE) <= set(has) else None
    return Played(time, table.stack(TURN), place, table.columns.get("hinge_angle"), force)
