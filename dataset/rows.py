"""The table of recordings: one row says everything that was drawn for a recording."""

import json
from typing import Any

import numpy as np
import pyarrow as pa

from imubench.arrays import Array
from imubench.dataset.columns import numbers
from imubench.dataset.playing import Made
from imubench.dataset.spec import Spec
from imubench.sim.imu_model import DeclaredMount
from imubench.sim.imu_profile import ChannelProfile
from imubench.sim.rigs import Mount, Segment

REAL, TEXT = pa.float64(), pa.string()


def _vector(n: int) -> pa.DataType:
    return pa.list_(REAL, n)


RECORDING = {
    "recording": pa.int32(),
    "name": TEXT,
    "split": TEXT,
    "seed": pa.int64(),
    "rig": pa.int32(),  # recordings of one rig have its number
    "family": TEXT,
    "base": TEXT,
    "base_quaternion": _vector(4),  # segment 1 -> world, of a fixed base
    "motion": TEXT,
    "free_swing": pa.list_(REAL, 2),  # start and end, s; empty of a motion by hand
    "body_mass": REAL,  # kg, of the swinging segment, as declared; empty as well
    "body_com": _vector(3),  # m
    "body_inertia": _vector(3),  # kg m^2
    "encoder_noise_std": REAL,  # rad, as declared; empty without an encoder
    "encoder_zero": REAL,  # rad
    "seconds": REAL,
    "rate": REAL,  # Hz
    "samples": pa.int32(),  # rows in the table of samples
    "gravity": REAL,  # m/s^2, as declared
    "true_gravity": REAL,
    "effects": pa.list_(pa.struct({"effect": TEXT, "at": TEXT, "parameters": TEXT})),  # parameters: JSON
}
MEASURED = {f"measured_{key}_std": REAL for key in ("position", "rotation")}  # m, rad; empty where it is not measured
SEGMENT = {"mass": REAL, "com": _vector(3), "inertia": _vector(3), "length": REAL}  # kg, m, kg m^2, m
IMU = {
    "profile": TEXT,
    "samples": pa.int32(),
    "position": _vector(3),  # m, segment frame: where the sensor is, springs unloaded
    "quaternion": _vector(4),  # sensor -> segment
    "declared_position": _vector(3),
    "declared_quaternion": _vector(4),
    "declared_position_std": REAL,  # m
    "declared_rotation_std": REAL,  # rad
    **{f"{k}_rms": REAL for k in ("gyro", "accel")},  # of what it read
    **{f"{k}_noise_std": REAL for k in ("gyro", "accel")},  # per sample, as declared
    **{f"{k}_range": REAL for k in ("gyro", "accel")},  # as declared
    **{
        f"{k}_{what}": _vector(n)
        for k in ("gyro", "accel")
        for what, n in (("bias", 3), ("scale", 3), ("misalignment", 6))
    },
}
"""Columns of an IMU; bias, scale and misalignment are the part's own and those of the effects, summed."""


def schema(spec: Spec) -> pa.Schema:
    """Return names and types of the columns of the table of recordings."""
    columns = dict(RECORDING)
    for n in numbers(spec):
        columns |= {f"segment{n}_{key}": kind for key, kind in (SEGMENT | MEASURED).items()}
        columns |= {f"imu{n}_{key}": kind for key, kind in IMU.items()}
    return pa.schema(columns)


def row(made: Made, seed: int) -> dict[str, Any]:
    """Return one recording's row."""
    drawn, recording, body = made.drawn, made.recording, made.recording.body
    effects = [e | {"parameters": json.dumps(e["parameters"], default=lambda a: a.tolist())} for e in drawn.effects]
    found: dict[str, Any] = {
        "recording": drawn.index,
        "name": recording.name,
        "split": drawn.split,
        "seed": seed,
        "rig": drawn.rig_index,
        "family": drawn.rig.family,
        "base": drawn.rig.base,
        "base_quaternion": drawn.rig.base_quaternion.tolist(),
        "motion": drawn.motion_name,
        "free_swing": recording.free_swings[0] if recording.free_swings else None,
        "body_mass": body and body.mass,
        "body_com": body and body.com.tolist(),
        "body_inertia": body and body.inertia.tolist(),
        "encoder_noise_std": drawn.encoder and drawn.encoder.noise_std,
        "encoder_zero": drawn.encoder and drawn.encoder.zero,
        "seconds": drawn.seconds,
        "rate": recording.imus[0].rate,
        "samples": made.truth.time.size,
        "gravity": drawn.declared_gravity,
        "true_gravity": drawn.rig.gravity,
        "effects": effects,
    }
    for n, segment in enumerate(drawn.rig.segments, 1):
        found |= _segment(f"segment{n}", segment)
    for pose in drawn.poses:
        found[f"{pose.segment}_measured_position_std"] = pose.position_noise_std
        found[f"{pose.segment}_measured_rotation_std"] = pose.rotation_noise_std
    for mount, imu in zip(drawn.rig.mounts, recording.imus, strict=True):
        part, nominal = drawn.parts[imu.name], drawn.nominal[imu.name]
        found |= _mounts(imu.name, mount, drawn.declared[imu.name])
        found |= {f"{imu.name}_profile": nominal.name, f"{imu.name}_samples": imu.time.size}
        for kind, channel in (("gyro", part.gyro), ("accel", part.accel)):
            found[f"{imu.name}_{kind}_rms"] = _rms(getattr(imu, kind))
            declared = {"noise_std": getattr(imu, f"{kind}_noise_std"), "range": getattr(imu, f"{kind}_range")}
            found |= {f"{imu.name}_{kind}_{key}": value for key, value in (declared | _errors(channel)).items()}
    return found


def _segment(name: str, segment: Segment) -> dict[str, Any]:
    return {
        f"{name}_mass": segment.mass,
        f"{name}_com": segment.com.tolist(),
        f"{name}_inertia": segment.inertia.tolist(),
        f"{name}_length": segment.length,
    }


def _mounts(name: str, mount: Mount, declared: DeclaredMount) -> dict[str, Any]:
    return {
        f"{name}_position": mount.position.tolist(),
        f"{name}_quaternion": mount.quaternion.tolist(),
        f"{name}_declared_position": declared.position.tolist(),
        f"{name}_declared_quaternion": declared.quaternion.tolist(),
        f"{name}_declared_position_std": declared.position_std,
        f"{name}_declared_rotation_std": declared.rotation_std,
    }


def _rms(vectors: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))


def _errors(channel: ChannelProfile) -> dict[str, Any]:
    return {key: getattr(channel, key).tolist() for key in ("bias", "scale", "misalignment")}
