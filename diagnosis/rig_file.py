"""The rig of a diagnosis' `model/`, read back from its MJCF: poses, springs, masses, friction, gravity."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.errors import InputError, unknown
from imubench.inputs.mjcf import compiled
from imubench.recording import RIGS
from imubench.sim.rigs import Mount, Rig, Segment, Spring
from imubench.sim.stability import write_no_log


def read_rig(path: Path, family: str) -> Rig:
    """Return the rig that an MJCF file of `imubench diagnose` describes: poses, springs, masses, friction, gravity."""
    if family not in RIGS:
        raise unknown("rig", family, RIGS)
    write_no_log()
    model = compiled(path)
    bodies = {model.body(i).name for i in range(model.nbody)}
    missing = [name for name in RIGS[family] if name not in bodies]
    if missing:
        raise InputError(f"{path}: expected a body '{missing[0]}', got {', '.join(sorted(bodies - {'world'}))}")
    joints = {model.joint(i).name: i for i in range(model.njnt)}
    if family == "hinge" and "hinge" not in joints:
        raise InputError(f"{path}: expected a joint 'hinge', got {', '.join(sorted(joints)) or 'none'}")
    mounts = tuple(_mount(model, name, joints) for name in ("imu1", "imu2") if name in bodies)
    segments = tuple(_segment(model, name) for name in RIGS[family])
    hinge = model.joint("hinge").dofadr[0] if "hinge" in joints else model.nv - 1
    changes: dict[str, Any] = {}
    if family == "hinge" and "base" not in joints:
        changes = {"base": "fixed", "base_quaternion": model.body("segment1").quat.copy()}
    if family == "hinge":
        changes |= {
            "drag": float(np.ravel(model.dof_dampingpoly[hinge])[0]),
            "stiffness": float(np.ravel(model.jnt_stiffness[joints["hinge"]])[0]),
            "spring_angle": float(model.qpos_spring[model.jnt_qposadr[joints["hinge"]]]),
        }
    return Rig(
        family,
        mounts,
        segments,
        gravity=float(-model.opt.gravity[2]),
        damping=float(model.dof_damping[hinge]) if family != "free" else 0.0,
        dry_friction=float(model.dof_frictionloss[hinge]) if family != "free" else 0.0,
        **changes,
    )


def _segment(model: Any, name: str) -> Segment:
    body = model.body(name)
    return Segment(float(body.mass[0]), body.ipos.copy(), np.diag(_inertia(body)).copy())


def _inertia(body: Any) -> Array:
    """Return the inertia (3, 3) of a body about its centre of mass, in its axes."""
    turn = rotations.to_matrix(body.iquat / np.linalg.norm(body.iquat))
    return np.asarray(turn @ np.diag(body.inertia) @ turn.T)


def _mount(model: Any, name: str, joints: Mapping[str, int]) -> Mount:
    body = model.body(name)
    com, mass, quaternion = body.ipos.copy(), float(body.mass[0]), body.quat.copy()
    about_pivot = _inertia(body) + mass * (com @ com * np.eye(3) - np.outer(com, com))
    gyration = float(np.sqrt(np.trace(about_pivot) / (3 * mass)))
    lever = model.site(name).pos.copy()
    found = {}
    for kind, inertia in (("slide", mass), ("hinge", mass * gyration**2)):
        names = [f"{name}_{kind}_{axis}" for axis in "xyz"]
        if all(n in joints for n in names):
            stiffness = np.array([float(np.ravel(model.jnt_stiffness[joints[n]])[0]) for n in names])
            damping = np.array([model.dof_damping[model.jnt_dofadr[joints[n]]] for n in names]).reshape(3)
            w = np.sqrt(stiffness / inertia)
            found[kind] = Spring(w / (2 * np.pi), damping / (2 * inertia * w))
    return Mount(
        body.pos + rotations.rotate(quaternion, lever),
        quaternion,
        found.get("slide"),
        found.get("hinge"),
        mass,
        gyration,
        com,
        lever,
    )
