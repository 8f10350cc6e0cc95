"""A diagnosis as a simulation: the rig with what was found in it, its motion, and its sensors' errors, on disk.

`model/` holds an MJCF file (mounts where the fit has them, soft ones on real springs), `imus.toml` (the sensors
and every effect found) and `motion.csv` (the recovered motion, a row a knot).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.baseline import whole
from imubench.diagnosis.evidence import Evidence, Played, Pose
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.diagnosis.simulation.swing_file import KEY, swing_tables
from imubench.effects import EFFECTS
from imubench.effects.effect import Effect
from imubench.errors import InputError
from imubench.format1.tables import write_table
from imubench.recording import Recording
from imubench.sim.compile import specify
from imubench.sim.injected import SWUNG
from imubench.sim.rigs import HEAVIEST, STANDARD_RIGS, Mount, Rig, Segment, springs

FORMAT = 1
SENSORS, MOTION = "imus.toml", "motion.csv"
SPRUNG = ("soft_mount", "rocking_mount")
GEOMETRY = ("mount_pose", "gravity", "viscous_friction", "dry_friction")
LIGHT = 1e-4  # of the declared body, which is with its sensor: as much does the model's sensor add to it
OF_A_HINGE = ("air_drag", "joint_spring", "inertia")  # MuJoCo's ball joint knows none of the first two


def rig_of(recording: Recording, mounts: Mapping[str, Pose], findings: Iterable[Finding] = ()) -> Rig:
    """Return the rig that MuJoCo plays: fitted mounts, springs where a finding has them, its torques and gravity.

    Where the recording has no IMU the rig has its usual one.
    """
    findings = tuple(findings)
    known = {(f.effect, f.at): {name: p.value for name, p in f.parameters.items()} for f in findings}
    standard = STANDARD_RIGS[recording.rig]()
    named = {f"imu{i + 1}": mount for i, mount in enumerate(standard.mounts)}
    changes: dict[str, Any] = {
        "mounts": tuple(
            _mount(mounts[imu], {name: values for (name, at), values in known.items() if at == imu})
            if imu in mounts
            else usual
            for imu, usual in named.items()
        ),
        "segments": _segments(recording, standard),
        "gravity": float(known.get(("gravity", "world"), {}).get("g", recording.gravity)),
        "damping": float(known.get(("viscous_friction", "joint"), {}).get("c", 0.0)),
        "dry_friction": float(known.get(("dry_friction", "joint"), {}).get("t", 0.0)),
    }
    if recording.body is not None:
        changes["mounts"] = tuple(replace(m, mass=LIGHT * recording.body.mass) for m in changes["mounts"])
    if recording.rig == "hinge":
        spring = known.get(("joint_spring", "joint"), {})
        changes |= {
            "base": recording.base,
            "base_quaternion": recording.base_quaternion,
            "drag": float(known.get(("air_drag", "joint"), {}).get("d", 0.0)),
            "stiffness": float(spring.get("k", 0.0)),
            "spring_angle": float(spring.get("q0", 0.0)),
        }
        scale = float(known.get(("inertia", "body"), {}).get("scale", 1.0))
        changes["segments"] = (*changes["segments"][:-1], _lighter(changes["segments"][-1], scale))
    return replace(standard, **changes)


def _lighter(segment: Segment, scale: float) -> Segment:
    """Return a segment of as much weight with its inertia about the joint divided by `scale`, if a body can be so."""
    c = segment.com
    about_joint = segment.inertia + segment.mass * (c @ c - c**2)
    try:
        return replace(segment, inertia=about_joint / scale - segment.mass * (c @ c - c**2))
    except InputError:
        return segment


def _mount(pose: Pose, found: Mapping[str, Mapping[str, Array]]) -> Mount:
    moved, soft, rocking = (found.get(name) for name in ("mount_pose", *SPRUNG))
    position, quaternion = pose.position, pose.quaternion
    if moved is not None:
        position = position + moved["translation"]
        quaternion = rotations.multiply(quaternion, rotations.exp(moved["rotation"]))
    mount = Mount(position, quaternion)
    if soft is not None:
        mount = replace(mount, translation=springs(soft["frequency"], soft["damping_ratio"]))
    if rocking is not None:
        com = rocking.get("com", np.zeros(3))
        gyration = float(rocking.get("gyration", mount.gyration))
        # Only com / gyration^2 shows, and a body that turns about every axis alike is no heavier on one side than so.
        smaller = min(1.0, 0.99 * HEAVIEST * gyration / max(float(np.linalg.norm(com)), 1e-12))
        mount = replace(
            mount,
            rotation=springs(rocking["frequency"], rocking["damping_ratio"]),
            com=com * smaller**2,
            gyration=gyration * smaller,
            lever=rocking.get("lever", np.zeros(3)),
        )
    return mount


def _segments(recording: Recording, standard: Rig) -> tuple[Segment, ...]:
    """Return the rig's segments, the swinging one as it is declared, where a body can be like that."""
    if recording.body is None:
        return standard.segments
    body = recording.body
    try:
        return (*standard.segments[:-1], Segment(body.mass, body.com, body.inertia))
    except InputError:
        return standard.segments


def write_model(d: Diagnosis, evidence: Evidence, folder: Path) -> str:
    """Write a diagnosis' simulation into an empty folder and return the name of its MJCF file."""
    recording = evidence.recording
    name = f"{recording.rig}.xml"
    spec = specify(rig_of(recording, evidence.mounts, whole(d)))
    spec.compile()
    (folder / name).write_text(spec.to_xml(), encoding="utf-8")
    write_table(folder / MOTION, motion_columns(evidence.motion))
    used = {level.group: level.used for level in evidence.levels}
    content = {
        "format": FORMAT,
        "recording": recording.name,
        "rig": recording.rig,
        "model": name,
        "motion": MOTION,
        "imu": [
            {
                "name": imu.name,
                "rate": float(imu.rate),
                "start": float(imu.time[0]),
                "samples": int(imu.time.size),
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
        "effect": [effect_table(f, recording.rig, bool(evidence.rolled_out)) for f in whole(d) if f.named],
    }
    (folder / SENSORS).write_text(toml(content), encoding="utf-8")
    return name


def effect_table(f: Finding, rig: str, swings: bool = True) -> dict[str, Any]:
    """Return a finding for imus.toml; `replayed` says whether the model's replay has it in.

    A torque moves nothing unless the replay rolls out a free swing; `swings` says whether it does.
    """
    parameters = {name: p.value.tolist() for name, p in f.parameters.items()}
    modelled = (*SPRUNG, *GEOMETRY, *(OF_A_HINGE if rig == "hinge" else ()))
    played = f.effect in modelled or sensor_law(f.effect, f.parameters) is not None
    played = played and (swings or f.effect not in SWUNG)
    return {"name": f.effect, "at": f.at, "replayed": played, "parameters": parameters}


def sensor_law(name: str, parameters: Iterable[str]) -> Effect | None:
    """Return the effect whose law turns a true reading, or its time, into what an IMU reports; None: not such a one."""
    effect = EFFECTS.get(name)
    if effect is None or {p.name for p in effect.parameters} != set(parameters):
        return None
    acts = any(getattr(type(effect), stage) is not getattr(Effect, stage) for stage in ("error", "clock"))
    return effect if acts else None


def motion_columns(motion: Played) -> dict[str, Array]:
    """Return a motion as columns: time, segment 1's orientation, its place or force, the hinge angle."""
    columns = {"time": motion.time} | dict(zip(("qw", "qx", "qy", "qz"), motion.quaternion1.T, strict=True))
    if motion.force is not None:
        columns |= dict(zip(("force_x", "force_y", "force_z"), motion.force.T, strict=True))
    else:
        columns |= dict(zip("xyz", motion.position.T, strict=True))
    return columns if motion.hinge_angle is None else columns | {"hinge_angle": motion.hinge_angle}


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
