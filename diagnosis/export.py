"""A diagnosis as a simulation: the rig with what was found in it, its motion, and its sensors' errors, on disk.

`model/` holds an MJCF file (mounts where the fit has them, soft ones on real springs, what the joint does and meets),
`imus.toml` (the sensors and every effect found), `motion.csv` (the recovered motion, two rows a knot) and a table for
every sensor that does something without a name: the signal that was fitted.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from imubench.arrays import Array
from imubench.diagnosis.baseline import whole
from imubench.diagnosis.evidence import Evidence, FittedEffect, Played
from imubench.diagnosis.found_rig import rig_of
from imubench.diagnosis.replay import told_play
from imubench.diagnosis.result import UNKNOWN, Diagnosis, Finding
from imubench.diagnosis.sensor_chain import chained
from imubench.effects import EFFECTS
from imubench.format1.tables import write_table
from imubench.recording import Imu, Recording
from imubench.sim.compile import specify
from imubench.sim.joints import Play

FORMAT = 1
SENSORS, MOTION = "imus.toml", "motion.csv"
IN_THE_RIG = (
    "mount_pose", "mount_shift", "soft_mount", "rocking_mount", "skin_sliding", "joint_play", "axis_coupling",
    "moving_centre", "moving_pivot", "viscous_friction", "dry_friction", "air_drag", "joint_spring", "end_stop",
    "inertia", "gravity",
)  # fmt: skip
"""The effects that are in the MJCF file, or in the motion."""
PLAY = ("play", "play_beside")  # columns of a motion
AT_THE_ENCODER = ("backlash",)
NAMES = {"gyro": ("gyr_x", "gyr_y", "gyr_z"), "accel": ("acc_x", "acc_y", "acc_z"), "torque": ("torque",)}


def plays(effect: str, rig: str) -> bool:
    """Return whether the replay of a `model/` has an effect of the library in it, on a rig."""
    known = EFFECTS.get(effect)
    if known is None or rig not in known.rigs:
        return False
    return effect in (*IN_THE_RIG, *AT_THE_ENCODER) or chained(effect)


def write_model(d: Diagnosis, evidence: Evidence, folder: Path) -> str:
    """Write a diagnosis' simulation into an empty folder and return the name of its MJCF file."""
    recording, found, fitted = evidence.recording, whole(d), evidence.motion.fitted
    name = f"{recording.rig}.xml"
    rig = rig_of(recording, evidence.mounts, found, fitted)
    spec = specify(rig)
    spec.compile()
    (folder / name).write_text(spec.to_xml(), encoding="utf-8")
    write_table(folder / MOTION, motion_columns(evidence.motion, rig.play))
    used = {level.group: level.used for level in evidence.levels}
    content = {
        "format": FORMAT,
        "recording": recording.name,
        "rig": recording.rig,
        "model": name,
        "motion": MOTION,
        "start": start_of(recording),  # s, of the stamps: what times of effects are counted from
        "imu": [
            {
                "name": imu.name,
                "rate": float(imu.rate),
                "start": float(imu.time[0]),
                "end": float(imu.time[-1]),
                "samples": int(imu.time.size),  # of the recording, those that were lost apart
                # of a triple that clips throughout nothing is left
                "gyro_noise_std": float(used.get(f"{imu.name}.gyro", imu.gyro_noise_std or 0.0)),
                "accel_noise_std": float(used.get(f"{imu.name}.accel", imu.accel_noise_std or 0.0)),
            }
            for imu in recording.imus
        ],
        "encoder": [
            {
                "joint": encoder.joint,
                "rate": float((encoder.time.size - 1) / (encoder.time[-1] - encoder.time[0])),
                "start": float(encoder.time[0]),
                "samples": int(encoder.time.size),
                "angle_noise_std": float(used["encoder.angle"]),
            }
            for encoder in recording.encoders
        ],
        "effect": [
            *(effect_table(f, recording.rig, own_of(f, fitted), recording) for f in found if f.named),
            *_unknown(found, fitted, folder),
        ],
    }
    (folder / SENSORS).write_text(toml(content), encoding="utf-8")
    return name


def start_of(recording: Recording) -> float:
    """Return the first stamp of a recording in s."""
    stamps = [imu.time for imu in recording.imus] + [encoder.time for encoder in recording.encoders]
    stamps += [pose.time for pose in recording.poses]
    return min(float(time[0]) for time in stamps)


def own_of(f: Finding, fitted: Sequence[FittedEffect]) -> FittedEffect | None:
    """Return the effect of a fit that a finding tells of, if there is one."""
    return next((own for own in fitted if (own.effect, own.at) == (f.effect, f.at)), None)


def effect_table(
    f: Finding, rig: str, own: FittedEffect | None = None, recording: Recording | None = None
) -> dict[str, Any]:
    """Return a finding for imus.toml: its numbers, those that only the fit has, and its settings.

    `replayed` says whether the model's replay has it in.
    """
    numbers = dict(own.values) if own is not None else {}
    if own is not None and "gap" in own.signals:
        numbers["gap"] = np.asarray(
            np.interp(0.0, own.time, own.signals["gap"][:, 0])
        )  # of a backlash, where it begins
    numbers |= {name: p.value for name, p in f.parameters.items()}
    settings = settings_of(f, own, recording)
    parameters = {name: np.asarray(value).tolist() for name, value in numbers.items()}
    return {"name": f.effect, "at": f.at, "replayed": plays(f.effect, rig), **settings, "parameters": parameters}


def settings_of(f: Finding, own: FittedEffect | None, recording: Recording | None) -> dict[str, Any]:
    """Return the channels of an effect that has some, and how samples are lost.

    The samples themselves show how: a finding tells a number and its unit.
    """
    if own is not None and own.settings.get("channels"):
        return {"channels": list(own.settings["channels"])}  # type: ignore[arg-type]
    if f.effect in ("saturation", "quantisation"):
        unit = next(iter(f.parameters.values())).unit
        return {"channels": ["gyro" if unit == "rad/s" else "accel"]}
    if f.effect == "dropouts":
        imus = [] if recording is None else [imu for imu in recording.imus if imu.name == f.at]
        share = float(f.parameters["fraction"].value)
        return {"mode": "held" if imus and 2 * held_share(imus[0]) > share else "missing"}
    return {}


def held_share(imu: Imu) -> float:
    """Return the share of an IMU's samples that say the one before again."""
    same = (np.diff(imu.gyro, axis=0) == 0).all(axis=1) & (np.diff(imu.accel, axis=0) == 0).all(axis=1)
    return float(same.mean())


def _unknown(found: Sequence[Finding], fitted: Sequence[FittedEffect], folder: Path) -> list[dict[str, Any]]:
    """Write the signals of what has no name, a table for each place, and return the effects for imus.toml."""
    out = []
    for at in dict.fromkeys(f.at for f in found if not f.named):
        own = [f for f in fitted if f.effect == UNKNOWN and f.at == at]
        table: dict[str, Any] = {"name": UNKNOWN, "at": at, "replayed": bool(own)}
        if own:
            table["signal"] = f"{UNKNOWN}_{at}.csv"
            write_table(folder / table["signal"], summed(own))
        out.append(table | {"parameters": {}})
    return out


def summed(fitted: Sequence[FittedEffect]) -> dict[str, Array]:
    """Return what several terms at one place add, as columns: time s since the start, and the channels they enter."""
    time = fitted[0].time
    columns = {"time": time}
    for part, names in NAMES.items():
        each = [(f.time, f.signals[part]) for f in fitted if part in f.signals]
        for i, name in enumerate(names if each else ()):
            columns[name] = np.sum([np.interp(time, t, x[:, i]) for t, x in each], axis=0)
    return columns


def motion_columns(motion: Played, play: Play | None = None) -> dict[str, Array]:
    """Return a motion as columns: time, segment 1's orientation, its place or force, hinge angle, what a play did."""
    columns = {"time": motion.time} | dict(zip(("qw", "qx", "qy", "qz"), motion.quaternion1.T, strict=True))
    if motion.force is not None:
        columns |= dict(zip(("force_x", "force_y", "force_z"), motion.force.T, strict=True))
    else:
        columns |= dict(zip("xyz", motion.position.T, strict=True))
    if motion.hinge_angle is not None:
        columns["hinge_angle"] = motion.hinge_angle
    if play is not None and (told := told_play(motion, play)) is not None:
        columns |= dict(zip(PLAY, told, strict=True))
    return columns


def toml(content: Mapping[str, Any]) -> str:
    """Return TOML as one would type it: lists of numbers on one line, a `[[table]]` for each entry of a list."""
    lines, tables = [], []
    for key, value in content.items():
        if isinstance(value, list) and all(isinstance(v, dict) for v in value):
            tables += [(f"[[{key}]]", v) for v in value]
        else:
            lines.append(f"{key} = {_inline(value)}")
    for head, table in tables:
        lines += ["", head]
        lines += [f"{key} = {_inline(value)}" for key, value in table.items() if not isinstance(value, dict)]
        for key, inner in table.items():
            if isinstance(inner, dict):
                lines += [f"[{head.strip('[]')}.{key}]", *(f"{k} = {_inline(v)}" for k, v in inner.items())]
    return "\n".join(lines) + "\n"


def _inline(value: Sequence[Any] | str | float | bool) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return tomli_w.dumps({"x": value}).removeprefix("x = ").rstrip("\n")


__all__ = ["FORMAT", "MOTION", "SENSORS", "effect_table", "motion_columns", "plays", "rig_of", "toml", "write_model"]
