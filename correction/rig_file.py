"""The rig of a diagnosis' `model/`, read back from its MJCF: poses, springs, masses, friction, gravity."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.errors import InputError, unknown
from imubench.inputs.mjcf import compiled
from imubench.models import is_rig, known_rigs
from imubench.models.tree import Tree, rig_tree
from imubench.sim.compile import CARRIER, SPRING_LAW, STOP_LAW
from imubench.sim.joint_model import PLAY
from imubench.sim.joints import Play, Stop
from imubench.sim.rigs import Mount, Rig, Segment, Slip, Spring
from imubench.sim.stability import write_no_log

NUMBERS_OF_A_LAW = {SPRING_LAW: 3, STOP_LAW: 3} | {
    f"imu{n}_{key}": width for n in (1, 2) for key, width in (("slip", 7), ("slide", 3), ("twist", 3))
}
"""How many numbers each law has that MuJoCo has no term for."""


def read_rig(path: Path, family: str) -> Rig:
    """Return the rig that an MJCF file of `imubench diagnose` describes: poses, springs, masses, friction, gravity."""
    if not is_rig(family):
        raise unknown("rig", family, known_rigs())
    write_no_log()
    model = compiled(path)
    bodies = {model.body(i).name for i in range(model.nbody)}
    tree = rig_tree(family)
    missing = [name for name in tree.names if name not in bodies]
    if missing:
        raise InputError(f"{path}: expected a body '{missing[0]}', got {', '.join(sorted(bodies - {'world'}))}")
    joints = {model.joint(i).name: i for i in range(model.njnt)}
    if tree.hinge is not None and tree.hinge.name not in joints:
        raise InputError(f"{path}: expected a joint '{tree.hinge.name}', got {', '.join(sorted(joints)) or 'none'}")
    try:
        return _rig(model, family, bodies, joints)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _rig(model: Any, family: str, bodies: Collection[str], joints: Mapping[str, int]) -> Rig:
    laws, gears, tree = _laws(model), _gears(model), rig_tree(family)
    mounts = tuple(_mount(model, name, joints, laws, gears) for name in tree.imus if name in bodies)
    scale = 1.0 - float(model.body_gravcomp[model.body(tree.last.name).id])
    segments = tuple(_segment(model, name, scale if name == tree.last.name else 1.0) for name in tree.names)
    changes: dict[str, Any] = {"inertia_scale": scale}
    if tree.clamps and tree.base is not None and tree.base.name not in joints:
        changes |= {"base": "fixed", "base_quaternion": model.body(tree.names[0]).quat.copy()}
    drag = damping = friction = 0.0
    if tree.joint is not None:
        dof = int(model.joint(tree.joint.name).dofadr[0]) if tree.joint.name in joints else model.nv - 1
        drag, damping = float(np.ravel(model.dof_dampingpoly[dof])[0]), float(model.dof_damping[dof])
        friction = float(model.dof_frictionloss[dof])
    if tree.hinge is not None:
        changes |= _hinge(model, tree, joints, gears)
    if tree.ball is not None:
        changes |= {"pivot_moves": "pivot_x" in joints} | _ball(laws)
    return Rig(
        family,
        mounts,
        segments,
        gravity=float(-model.opt.gravity[2]),
        damping=damping,
        dry_friction=friction,
        drag=drag,
        **changes,
    )


def _held(model: Any) -> set[str]:
    """Return the bodies that a weld holds to their parent, springs or not: it is on."""
    welds = (i for i in range(model.neq) if model.eq_type[i] == mujoco.mjtEq.mjEQ_WELD and model.eq_active0[i])
    return {model.body(model.eq_obj2id[i]).name for i in welds}


def _laws(model: Any) -> dict[str, Array]:
    """Return the numbers of what MuJoCo has no term for, by name; see `sim.compile.laws_of`."""
    found = {}
    for i in range(model.nnumeric):
        name, numbers = model.numeric(i).name, np.array(model.numeric(i).data)
        if name in NUMBERS_OF_A_LAW and numbers.size != NUMBERS_OF_A_LAW[name]:
            raise InputError(f"numeric '{name}': expected {NUMBERS_OF_A_LAW[name]} numbers, got {numbers.size}")
        found[name] = numbers
    return found


def _gears(model: Any) -> dict[str, Array]:
    """Return the vector of every joint that an equality gears to another one: its axis times the gear."""
    found = {}
    for i in range(model.neq):
        if model.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT:
            joint = model.joint(model.eq_obj1id[i])
            found[joint.name] = model.jnt_axis[joint.id] * model.eq_data[i][1]
    return found


def _hinge(model: Any, tree: Tree, joints: Mapping[str, int], gears: Mapping[str, Array]) -> dict[str, Any]:
    """Return what a hinge does beside turning, and what it meets."""
    own = joints[tree.last.joints[-1].name]
    dof = int(model.jnt_dofadr[own])
    changes: dict[str, Any] = {
        "stiffness": float(np.ravel(model.jnt_stiffness[own])[0]),
        "spring_angle": float(model.qpos_spring[model.jnt_qposadr[own]]),
    }
    if {"coupling_x", "coupling_z"} <= set(gears):
        changes["coupling"] = np.array([gears["coupling_x"][0], gears["coupling_z"][2]])
    if "centre" in gears:
        changes["centre"] = gears["centre"]
    if model.jnt_limited[own]:
        low, high = model.jnt_range[own]
        if (model.jnt_solref[own] > 0).any():
            got = model.jnt_solref[own].tolist()
            raise InputError(f"joint '{model.joint(own).name}': expected solreflimit as -stiffness -damping, got {got}")
        stiffness, damping = -model.jnt_solref[own] / model.dof_invweight0[dof]
        changes["stop"] = Stop(float(low if abs(low) < abs(high) else high), float(stiffness), float(damping))
    if PLAY in joints:
        changes["play"] = _play(model, tree, joints[PLAY])
    return changes


def _play(model: Any, tree: Tree, joint: int) -> Play:
    """Return a play: J + armature from its own axis, the springs by that."""
    dof, axis = int(model.jnt_dofadr[joint]), model.jnt_axis[joint]
    body = model.body(tree.last.name)
    com = body.ipos
    own = float(axis @ _inertia(body) @ axis + body.mass[0] * (com @ com - (com @ axis) ** 2))
    whole = own + float(model.dof_armature[dof])
    stiffness, damping = float(np.ravel(model.jnt_stiffness[joint])[0]), float(model.dof_damping[dof])
    w = np.sqrt(stiffness / whole)
    ratio = damping / (2 * whole * w) if w > 0 else 0.0
    direction = float(np.arctan2(axis[2], axis[0]))
    return Play(float(model.jnt_range[joint][1]), direction, w / (2 * np.pi), ratio, min(own / max(whole, 1e-15), 1.0))


def _ball(laws: Mapping[str, Array]) -> dict[str, Any]:
    """Return what a pendulum's swing meets."""
    changes: dict[str, Any] = {}
    if (spring := laws.get(SPRING_LAW)) is not None:
        changes |= {
            "stiffness": float(spring[0]),
            "spring_angle": float(spring[1]),
            "spring_conserves": bool(spring[2]),
        }
    if (stop := laws.get(STOP_LAW)) is not None:
        changes["stop"] = Stop(*(float(x) for x in stop[:3]))
    return changes


def _segment(model: Any, name: str, scale: float) -> Segment:
    """Return a segment as it is without `scale`, m l / I by which it is lighter and weighs as much."""
    body = model.body(name)
    return Segment(scale * float(body.mass[0]), body.ipos.copy(), scale * np.diag(_inertia(body)))


def _inertia(body: Any) -> Array:
    """Return the inertia (3, 3) of a body about its centre of mass, in its axes."""
    turn = rotations.to_matrix(body.iquat / np.linalg.norm(body.iquat))
    return np.asarray(turn @ np.diag(body.inertia) @ turn.T)


def _mount(
    model: Any, name: str, joints: Mapping[str, int], laws: Mapping[str, Array], gears: Mapping[str, Array]
) -> Mount:
    body = model.body(name)
    carriers = [model.body(i) for i in range(model.nbody) if model.body(i).name == f"{name}{CARRIER}"]
    place = carriers[0] if carriers else body
    com, mass, quaternion = body.ipos.copy(), float(body.mass[0]), place.quat.copy()
    about_pivot = _inertia(body) + mass * (com @ com * np.eye(3) - np.outer(com, com))
    gyration = float(np.sqrt(np.trace(about_pivot) / (3 * mass)))
    lever = model.site(name).pos.copy()
    found = {}
    for kind, inertia in (("slide", mass), ("hinge", mass * gyration**2)):
        names = [f"{name}_{kind}_{axis}" for axis in "xyz"]
        if all(n in joints for n in names) and name not in _held(model):
            stiffness = np.array([float(np.ravel(model.jnt_stiffness[joints[n]])[0]) for n in names])
            damping = np.array([model.dof_damping[model.jnt_dofadr[joints[n]]] for n in names]).reshape(3)
            w = np.sqrt(stiffness / inertia)
            found[kind] = Spring(w / (2 * np.pi), damping / (2 * inertia * w))
    slip = laws.get(f"{name}_slip")
    slide, twist = (gears.get(f"{name}_path_{k}", laws.get(f"{name}_{k}", np.zeros(3))) for k in ("slide", "twist"))
    if f"{name}_path_slide" in gears:
        slide = rotations.rotate(quaternion, slide)  # the file has it in axes of the sensor's body
    return Mount(
        place.pos + rotations.rotate(quaternion, lever),
        quaternion,
        found.get("slide"),
        found.get("hinge"),
        mass,
        gyration,
        com,
        lever,
        slip=None if slip is None else Slip(float(slip[0]), slip[1:4], slip[4:7]),
        slide=slide,
        twist=twist,
    )
