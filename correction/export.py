"""A diagnosis as a simulation: the rig with what was found in it, its motion, and its sensors' errors, on disk.

`model/` holds an MJCF file (mounts where the fit has them, soft ones on real springs, what the joint does and meets),
`imus.toml` (the sensors and every effect found, without names that are not likely), `motion.csv` (the recovered motion,
two rows a knot) and a table for every sensor that does something without a name: the signal that was fitted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from imubench.arrays import Array
from imubench.correction.found_chain import chain_of
from imubench.correction.found_rig import rig_of
from imubench.correction.replay import play_of_motion
from imubench.correction.sensor_chain import Link, plays
from imubench.correction.swing_file import KEY, swing_tables
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.evidence import Evidence, Played
from imubench.diagnosis.result import UNKNOWN, Diagnosis, Finding
from imubench.diagnosis.sensor_errors.baseline import whole
from imubench.effects import EFFECTS
from imubench.format1.tables import write_table
from imubench.format1.write import IMU
from imubench.models.tree import rig_tree
from imubench.recording import span_of
from imubench.sim.compile import specify
from imubench.sim.joints import Play

MODEL_FORMAT = 1
SENSORS_FILE, MOTION_FILE = "imus.toml", "motion.csv"
PLAY_COLUMNS = ("play", "play_beside")  # columns of a motion
CHANNEL_COLUMNS = {**IMU, "torque": ("torque",)}


def write_model(d: Diagnosis, evidence: Evidence, folder: Path) -> str:
    """Write a diagnosis' simulation into an empty folder and return the name of its MJCF file."""
    recording, fitted = evidence.recording, evidence.replayed.fitted
    found = as_rolled_out(likely(whole(d)), evidence.taught)
    name = f"{recording.rig}.xml"
    rig = rig_of(recording, evidence.mounts, found, fitted)
    spec = specify(rig)
    spec.compile()
    (folder / name).write_text(spec.to_xml(), encoding="utf-8")
    write_table(folder / MOTION_FILE, motion_columns(evidence.replayed, rig.play))
    used = {level.group: level.used for level in evidence.levels}
    chain, swings = chain_of(found, fitted, recording), bool(evidence.rolled_out)
    content = {
        "format": MODEL_FORMAT,
        "recording": recording.name,
        "rig": recording.rig,
        "model": name,
        "motion": MOTION_FILE,
        "start": span_of(recording)[0],  # s, of the stamps: what times of effects are counted from
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
        KEY: swing_tables(evidence.rolled_out, recording.rig),
        "effect": [effect_table(at, link, recording.rig, swings, folder) for at, link in chain],
    }
    (folder / SENSORS_FILE).write_text(toml(content), encoding="utf-8")
    return name


def likely(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings without the names that are not likely: the motion of a replay is recovered without them."""
    return tuple(f for f in findings if not f.named or f.confidence >= CONFIDENCE.counts)


def as_rolled_out(found: Sequence[Finding], taught: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings with the numbers that roll-outs show, where they show any: of these the replay is judged."""
    numbers = {(f.effect, f.at): f.parameters for f in taught}
    return tuple(replace(f, parameters={**f.parameters, **numbers.get((f.effect, f.at), {})}) for f in found)


def effect_table(at: str, link: Link, rig: str, swings: bool, folder: Path) -> dict[str, Any]:
    """Return an effect for imus.toml: its numbers and settings; the signal of what has no name is a table beside it.

    `replayed` says whether the model's replay has it in. What drives a free swing moves nothing unless the replay rolls
    one out; `swings` says whether it does.
    """
    if link.effect == UNKNOWN:
        in_place = at.startswith("imu") or (
            swings and rig_tree(rig).hinge is not None
        )  # a torque about a hinge is a number
        table: dict[str, Any] = {"name": UNKNOWN, "at": at, "replayed": bool(link.signals) and in_place}
        if link.signals:
            table["signal"] = f"{UNKNOWN}_{at}.csv"
            write_table(folder / table["signal"], signal_columns(link))
        return table | {"parameters": {}}
    replayed = plays(link.effect, rig) and (swings or not EFFECTS[link.effect].rolled_out)
    parameters = {name: np.asarray(value).tolist() for name, value in link.values.items()}
    return {"name": link.effect, "at": at, "replayed": replayed, **link.settings, "parameters": parameters}


def signal_columns(link: Link) -> dict[str, Array]:
    """Return the signal of what has no name as columns: time s since the start, and the channels it enters."""
    columns = {"time": link.time}
    for part, names in CHANNEL_COLUMNS.items():
        columns |= dict(zip(names, link.signals[part].T, strict=True)) if part in link.signals else {}
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
    if play is not None and (told := play_of_motion(motion, play)) is not None:
        columns |= dict(zip(PLAY_COLUMNS, told, strict=True))
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


__all__ = ["MODEL_FORMAT", "MOTION_FILE", "SENSORS_FILE", "effect_table", "motion_columns", "toml", "write_model"]
