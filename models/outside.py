"""Rigs that installed packages offer: read from their MJCF, and put into the frames and names of the bench.

A package offers a rig by an entry point of the group `imubench.rigs`, which leads to a `RigFile`. Its tree has to be
one of ours: a body that moves at will, a limb on a ball joint, or two segments on a hinge, an IMU on each. What is
simulated and fitted is a file written anew from it (`plain`): the segments' masses, the IMUs' poses, and nothing else.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.entry_points import RIGS, from_package
from imubench.errors import InputError, shown, unknown
from imubench.inputs.limits import TEXT_BYTES
from imubench.inputs.mjcf import compiled_mjcf, parsed_mjcf
from imubench.models import NAME, RIG_FILES, RigFile, known_rigs
from imubench.models.tree import BALL, FREE, HINGE, Tree, tree_of

KINDS: Mapping[tuple[tuple[str, ...], ...], str] = {
    ((FREE,),): FREE,
    ((BALL,),): BALL,
    ((FREE,), (HINGE,)): HINGE,
}
"""By the joints of each segment: the kind of rig."""
WANTED = "one body on a free joint, one on a ball joint, or one on a free joint and another on a hinge on it"
RESISTING = {
    "jnt_limited": "a range",
    "jnt_stiffness": "a stiffness",
    "dof_damping": "a damping",
    "dof_frictionloss": "a frictionloss",
    "dof_armature": "an armature",
}
"""What a joint of a file must not have: an effect or a number of the rig says what a joint meets."""
PRODUCTS = 0.01  # of the largest moment: a limb on a ball joint swings as if its products of inertia were none
SHORT = 1e-6  # m: nearer to the joint there is no direction
CASE = (0.029, 0.017, 0.0075)  # m, half of an IMU's box, as in our files


@dataclass(frozen=True)
class Body:
    """A segment in the frame that the bench has it in."""

    mass: float  # kg, without its IMU
    com: Array  # (3,) m
    inertia: Array  # (3, 3) kg m^2 about the com
    far: Array | None  # (3,) m, its far end; None: it has no direction
    radius: float  # m, of its picture
    position: Array  # (3,) m, of its IMU
    quaternion: Array  # (4,) IMU -> segment


def find_rig(name: str) -> RigFile:
    """Return the rig that a package offers under a name.

    Raises:
        InputError: none does, two do, it cannot be imported, or it is no `RigFile`.
    """
    found = from_package(RIGS, name, "rig", RigFile) if NAME.fullmatch(name) and name not in RIG_FILES else None
    if not isinstance(found, RigFile):
        raise unknown("rig", name, known_rigs())
    return found


def plain(name: str) -> str:
    """Return the MJCF of a package's rig in the bench's frames and names.

    Segments are `segment1` and `segment2`, IMUs `imu1` and `imu2`, joints `base` and `hinge`. On a hinge both segment
    frames have their origin in it, y along its axis, x where the second segment extends; on a ball joint z points away
    from where the limb extends; the frame of a free body is its own. The angle is zero as the file draws the rig.

    Raises:
        InputError: no such rig, as in `find_rig`; or its tree is none of ours.
    """
    return plain_of(name, find_rig(name))


def rig_key(name: str) -> str:
    """Return what changes with a package's rig: a hash of what is simulated of it; of one of ours nothing."""
    return "" if name in RIG_FILES else sha256(plain(name).encode()).hexdigest()


@lru_cache(64)
def plain_of(name: str, file: RigFile) -> str:
    """Return what `plain` does of a file that a package offers under a name.

    Raises:
        InputError: its texts are none, or its tree is none of ours.
    """
    import mujoco

    where = f"rig '{name}'"
    if not isinstance(file.mjcf, str) or not isinstance(file.summary, str):
        raise InputError(f"{where}: expected texts as summary and mjcf, got {shown(file.summary)}, {shown(file.mjcf)}")
    content = file.mjcf.encode(errors="replace")
    if len(content) > TEXT_BYTES:
        raise InputError(f"{where}: expected at most {TEXT_BYTES:,} bytes of MJCF, got {len(content):,}")
    spec = parsed_mjcf(content, where)
    _check_names(spec, where)
    model, tree = compiled_mjcf(spec, where), tree_of(spec)
    kind = _kind(tree, where)
    _check_joints(tree, model, where)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    origin, axes = _frame(kind, tree, model, data)
    with np.errstate(over="ignore", invalid="ignore"):  # said below
        bodies = [_body(s, tree, model, data, (origin, axes), where) for s in range(len(tree.names))]
    if not all(
        np.isfinite(np.hstack([b.mass, b.com, b.inertia.ravel(), b.position, b.quaternion])).all() for b in bodies
    ):
        raise InputError(f"{where}: expected lengths and masses that can be reckoned with, got larger ones")
    return _written(name, kind, bodies)


def _check_names(spec: Any, where: str) -> None:
    """Raise `InputError` where a body that may be a segment has no name."""
    for body in spec.bodies:
        if not body.name and (body.joints or body.parent.name == "world"):
            raise InputError(f"{where}: expected a name of every body that a joint moves, got none")


def _kind(tree: Tree, where: str) -> str:
    """Return what kind of rig a tree is; `InputError` where it is none of ours."""
    joints = tuple(tuple(joint.kind for joint in segment.joints) for segment in tree.segments)
    on_the_first = [segment.parent == tree.names[0] for segment in tree.segments[1:]]
    if joints not in KINDS or not all(on_the_first):
        got = ", ".join(
            f"{s.name or 'a body'} ({' '.join(j) or 'fixed'})" for s, j in zip(tree.segments, joints, strict=True)
        )
        raise InputError(f"{where}: expected {WANTED}, got {got or 'no body'}")
    for segment in tree.segments:
        if len(segment.imus) != 1:
            names = ", ".join(imu.name for imu in segment.imus) or "none"
            raise InputError(
                f"{where}: expected one site with a gyro and an accelerometer on {segment.name}, got {names}"
            )
    return KINDS[joints]


def _check_joints(tree: Tree, model: Any, where: str) -> None:
    """Raise `InputError` where a joint meets something."""
    for joint in range(model.njnt):
        if model.body(int(model.jnt_bodyid[joint])).name not in tree.names:
            continue  # of an IMU's own mount
        if not model.jnt_axis[joint].any():  # of numbers whose squares are infinite, or none
            raise InputError(f"{where}: expected a direction as the axis of a hinge, got a length of 0 or infinity")
        dof = int(model.jnt_dofadr[joint])
        for key, words in RESISTING.items():
            if np.any(getattr(model, key)[joint if key.startswith("jnt") else dof]):
                said = model.joint(joint).name or "its joint"
                raise InputError(
                    f"{where}: expected {said} without {words}: what a joint meets is an effect or a number of the rig"
                )


def _frame(kind: str, tree: Tree, model: Any, data: Any) -> tuple[Array, Array]:
    """Return origin (3,) m and axes (3, 3), in columns, of the segments' frame, in the world as the file draws it."""
    last = data.body(tree.last.name)
    own = last.xmat.reshape(3, 3)
    if kind == FREE:
        return last.xpos.copy(), own
    joint = int(model.body_jntadr[model.body(tree.last.name).id])
    origin = data.xanchor[joint].copy()
    far, _ = _picture(tree.last.name, model, data, (origin, np.eye(3)))
    away = _mass(_parts(tree.last.name, tree, model), model, data)[1] - origin if far is None else far
    if kind == HINGE:
        y = data.xaxis[joint] / np.linalg.norm(data.xaxis[joint])
        x = _across([away, *own.T], y)
        return origin, np.stack([x, y, np.cross(x, y)], axis=1)
    z = -away / np.linalg.norm(away) if np.linalg.norm(away) > SHORT else own[:, 2]
    x = _across([own[:, 0], own[:, 1]], z)
    return origin, np.stack([x, np.cross(z, x), z], axis=1)


def _across(candidates: list[Array], axis: Array) -> Array:
    """Return the part of the first vector that has one across a unit vector, as a unit vector."""
    parts = [v - (v @ axis) * axis for v in candidates]
    found = next(v for v in parts if np.linalg.norm(v) > SHORT)
    return np.asarray(found / np.linalg.norm(found))


def _parts(segment: str, tree: Tree, model: Any) -> list[int]:
    """Return the bodies that a segment is made of, without what is its IMU."""
    found = [model.body(segment).id]
    for body in range(1, model.nbody):
        fixed = not model.body_jntnum[body] and model.body_parentid[body] in found and body not in found
        if fixed and model.body(body).name not in tree.sites:
            found.append(body)
    return found


def _mass(parts: list[int], model: Any, data: Any) -> tuple[float, Array, Array]:
    """Return mass kg, com (3,) m and inertia (3, 3) kg m^2 about it of some bodies, in the world."""
    masses = model.body_mass[parts]
    mass = float(masses.sum())
    com = masses @ data.xipos[parts] / max(mass, 1e-30)
    inertia = np.zeros((3, 3))
    for body, m in zip(parts, masses, strict=True):
        turn, d = data.ximat[body].reshape(3, 3), data.xipos[body] - com
        inertia += turn @ np.diag(model.body_inertia[body]) @ turn.T + m * (d @ d * np.eye(3) - np.outer(d, d))
    return mass, com, inertia


def _body(number: int, tree: Tree, model: Any, data: Any, frame: tuple[Array, Array], where: str) -> Body:
    """Return a segment in the bench's frame."""
    import mujoco

    segment, (origin, axes) = tree.segments[number], frame
    name, site = segment.name, segment.imus[0].name
    mass, com, inertia = _mass(_parts(name, tree, model), model, data)
    com, inertia = axes.T @ (com - origin), axes.T @ inertia @ axes
    off = np.abs(inertia - np.diag(np.diag(inertia))).max()
    if tree.ball is not None and off > PRODUCTS * inertia.max():
        raise InputError(
            f"{where}: expected a limb whose principal axes are along it and across it, got products of inertia of "
            f"{100 * off / inertia.max():.2g} % of its largest moment; an <inertial> in its body can say so"
        )
    turn = np.zeros(4)
    mujoco.mju_mat2Quat(turn, (axes.T @ data.site(site).xmat.reshape(3, 3)).ravel())
    far, radius = _picture(name, model, data, frame)
    if far is None and tree.kind != FREE and np.linalg.norm(com) > SHORT:
        far, radius = 2 * com, 0.1 * float(np.linalg.norm(com))
    return Body(mass, com, inertia, far, radius, axes.T @ (data.site(site).xpos - origin), turn)


def _picture(name: str, model: Any, data: Any, frame: tuple[Array, Array]) -> tuple[Array | None, float]:
    """Return the far end (3,) m and the radius in m of a segment's first capsule; None where it has none."""
    import mujoco

    origin, axes = frame
    for geom in np.flatnonzero(model.geom_bodyid == model.body(name).id):
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
            half = model.geom_size[geom][1] * data.geom_xmat[geom].reshape(3, 3)[:, 2]
            ends = [axes.T @ (data.geom_xpos[geom] + sign * half - origin) for sign in (-1, 1)]
            return max(ends, key=np.linalg.norm), float(model.geom_size[geom][0])
    return None, 0.0


def _written(name: str, kind: str, bodies: list[Body]) -> str:
    """Return the MJCF of a rig, as our own files have it."""
    joints: Mapping[str, list[str]] = {
        FREE: ['<freejoint name="base"/>'],
        BALL: ['<joint name="base" type="ball"/>'],
        HINGE: ['<freejoint name="base"/>', '<joint name="hinge" type="hinge" axis="0 1 0"/>'],
    }
    lines = []
    for n, (body, joint) in enumerate(zip(bodies, joints[kind], strict=True), 1):
        lines += [
            f'<body name="segment{n}">',
            joint,
            f'<inertial pos="{_text(body.com)}" mass="{_text(body.mass)}" '
            f'diaginertia="{_text(np.diag(body.inertia))}"/>',
            _geom(n, body),
            f'<site name="segment{n}"/>',
            f'<body name="imu{n}" pos="{_text(body.position)}" quat="{_text(body.quaternion)}">',
            '<inertial pos="0 0 0" mass="0.016" diaginertia="3.6e-6 3.6e-6 3.6e-6"/>',
            f'<geom name="imu{n}" type="box" size="{_text(CASE)}" mass="0" rgba="1 0.55 0.1 1"/>',
            f'<site name="imu{n}"/>',
            "</body>",
        ]
    sensors = [
        f'<{k} name="imu{n}_{k}" site="imu{n}"/>' for n in range(1, len(bodies) + 1) for k in ("gyro", "accelerometer")
    ]
    return "\n".join(
        [
            f'<mujoco model="{name}">',
            '<option timestep="0.001" gravity="0 0 -9.81" integrator="implicitfast"><flag contact="disable"/></option>',
            "<worldbody>",
            *lines,
            *["</body>"] * len(bodies),
            "</worldbody>",
            f"<sensor>{''.join(sensors)}</sensor>",
            "</mujoco>",
        ]
    )


def _geom(n: int, body: Body) -> str:
    """Return a segment's picture: a capsule from beside the joint to its far end, or a box about its origin."""
    shape = f'name="segment{n}" mass="0" rgba="0.45 0.55 0.65 1"'
    if body.far is None:
        return f'<geom type="box" size="0.05 0.05 0.02" {shape}/>'
    return (
        f'<geom type="capsule" fromto="{_text(0.1 * body.far)} {_text(body.far)}" size="{_text(body.radius)}" {shape}/>'
    )


def _text(*values: Any) -> str:
    """Return numbers to 12 digits; what rounding makes of a zero is one."""
    return " ".join(f"{round(float(v), 15) + 0.0:.12g}" for v in np.ravel(values))


__all__ = ["find_rig", "plain", "plain_of", "rig_key"]
