"""The `model/` of a diagnosis, played: MJCF, sensors, effects and motion become a recording."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.export import SENSORS
from imubench.diagnosis.read_model import Model, Sampling, read_model, tables, text
from imubench.diagnosis.replay import played_through
from imubench.diagnosis.sensor_chain import Link, read_by
from imubench.effects.joints import Backlash
from imubench.errors import InputError, shown, unknown
from imubench.inputs.toml import load_toml
from imubench.recording import Encoder, Imu, Recording
from imubench.truth import Truth


def is_model(folder: Path) -> bool:
    """Return whether a folder is a diagnosis' model."""
    return (Path(folder) / SENSORS).is_file()


def check_same(folder: Path, recording: Recording) -> None:
    """Raise `InputError` where a `model/` folder, if it is one, was made from other samples than a recording's."""
    if not is_model(folder):
        return
    path = folder / SENSORS
    for i, table in enumerate(tables(load_toml(path), "imu", path)):
        where = f"{path}, imu[{i}]"
        name, imus = text(table, "name", where), {i.name: i for i in recording.imus}
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
    model = read_model(folder)
    sensors = (*model.imus.values(), *model.encoders.values())
    truth = played_through(model.rig, model.motion, model.start, model.end - model.start, max(s.rate for s in sensors))
    made = []
    for name, own in model.imus.items():
        mount = model.rig.mounts[int(name[-1]) - 1]
        gyro_std, accel_std = own.noise
        noise = gyro_std, accel_std
        time, gyro, accel = read_by(truth, model.start, own.stamps, name, model.chain(name), noise, rng)
        pose = mount.position, mount.quaternion
        made.append(Imu(name, time, gyro, accel, own.rate, *noise, None, None, *pose))
    recording = Recording(
        model.recording,
        model.rig.family,
        tuple(made),
        encoders=tuple(_encoder(model, truth, joint, own, rng) for joint, own in model.encoders.items()),
        gravity=model.rig.gravity,
        base=model.rig.base,
        base_quaternion=model.rig.base_quaternion,
    )
    return recording, truth


def _encoder(model: Model, truth: Truth, joint: str, own: Sampling, rng: np.random.Generator) -> Encoder:
    """Return what an encoder reads; behind a backlash it follows the joint with free play."""
    if truth.joint_angle is None:
        raise InputError(f"encoder {joint}: expected a hinge rig, got '{truth.rig}'")
    read = np.interp(own.stamps - model.start, truth.time, encoder_angle(model, truth.joint_angle))
    (std,) = own.noise
    return Encoder(joint, own.stamps, read + std * rng.standard_normal(read.size), std)


def encoder_angle(model: Model, angle: Array) -> Array:
    """Return the angle (n,) rad of the encoder's side of a joint that turns by `angle` (n,)."""
    for link in (link for _, link in model.effects if link.effect == "backlash"):
        gap = float(np.ravel(link.values.get("gap", np.zeros(1)))[0])
        angle = Backlash.played(angle, float(np.ravel(link.values["range"])[0]), gap)
    return angle


def reported(
    truth: Truth, start: float, stamps: Array, name: str, effects: Mapping[str, Mapping[str, Array]]
) -> tuple[Array, Array]:
    """Return rate and specific force (n, 3) as an IMU reports them, nothing of chance in them.

    Args:
        truth: of the rig; its time 0 is `start` s.
        start: s, in the stamps' own clock.
        stamps: (n,) s.
        name: of the sensor.
        effects: numbers by effect, all with their usual settings.
    """
    chain = [Link(effect, values) for effect, values in effects.items()]
    _, gyro, accel = read_by(truth, start, stamps, name, chain)
    return gyro, accel


__all__ = ["check_same", "encoder_angle", "is_model", "replay", "reported"]
