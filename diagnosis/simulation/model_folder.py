"""The `model/` of a diagnosis, played: MJCF, sensors, effects and motion become a recording.

Inside its free swings the rig is rolled out by forces alone; elsewhere the recovered motion is prescribed.
"""

from pathlib import Path

import numpy as np

from imubench.correction.export import SENSORS_FILE
from imubench.correction.read_model import Model, Sampling, read_model, tables, text
from imubench.correction.sensor_chain import angle_read, read_by, torque_of
from imubench.diagnosis.simulation.splice import from_row, played
from imubench.errors import InputError, shown, unknown
from imubench.inputs.toml import load_toml
from imubench.recording import Encoder, Imu, Recording
from imubench.truth import Truth


def is_model(folder: Path) -> bool:
    """Return whether a folder is a diagnosis' model."""
    return (Path(folder) / SENSORS_FILE).is_file()


def check_same(folder: Path, recording: Recording) -> None:
    """Raise `InputError` where a `model/` folder, if it is one, was made from other samples than a recording's."""
    if not is_model(folder):
        return
    path = folder / SENSORS_FILE
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
    truth, start = played_early(model)
    first = start - model.start
    made = []
    for name, own in model.imus.items():
        mount = model.rig.mounts[int(name[-1]) - 1]
        gyro_std, accel_std = own.noise
        noise = gyro_std, accel_std
        time, gyro, accel = read_by(truth, model.start, own.stamps, name, model.chain(name), noise, rng, first)
        pose = mount.position, mount.quaternion
        made.append(Imu(name, time, gyro, accel, own.rate, *noise, None, None, *pose))
    recording = Recording(
        model.recording,
        model.rig.family,
        tuple(made),
        encoders=tuple(_encoder(model, truth, first, joint, own, rng) for joint, own in model.encoders.items()),
        gravity=model.rig.gravity,
        base=model.rig.base,
        base_quaternion=model.rig.base_quaternion,
    )
    return recording, beginning(model, truth, start)


def played_early(model: Model) -> tuple[Truth, float]:
    """Return MuJoCo's truth of a model from where a sensor's clock first reads it, and when that is in s.

    The motion is prescribed, free swings are rolled out; the time is of the recording's clock.
    """
    rate = max(s.rate for s in (*model.imus.values(), *model.encoders.values()))
    torque = torque_of(model.effects, model.start) if model.rig.tree.hinge is not None else None
    return played(model.rig, model.motion, model.effects, (model.start, model.end), rate, model.swings, torque)


def beginning(model: Model, truth: Truth, start: float) -> Truth:
    """Return a truth whose first row is at `start` s from the model's first sample on."""
    return from_row(truth, round((model.start - start) / float(truth.time[1] - truth.time[0])))


def _encoder(model: Model, truth: Truth, first: float, joint: str, own: Sampling, rng: np.random.Generator) -> Encoder:
    """Return what an encoder reads; behind a backlash it follows the joint with free play.

    `first`: s, how far behind the model's start the truth's first row is.
    """
    read = angle_read(truth, model.start, own.stamps, model.effects, first)
    (std,) = own.noise
    return Encoder(joint, own.stamps, read + std * rng.standard_normal(read.size), std)


__all__ = ["check_same", "is_model", "played_early", "replay"]
