"""A rig's numbers become a MuJoCo model (MjSpec), with the sensors that read the truth."""

from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

from imubench import rotations
from imubench.models import mjcf
from imubench.models.tree import rig_spec, rig_tree
from imubench.sim.joint_model import PLAY, TINY_ARMATURE, along, gear, lighten, set_joint
from imubench.sim.rigs import Mount, Rig
from imubench.sim.stability import write_no_log

DRIVEN_ARMATURE = 1e13
"""Inertia of a driven joint, kg m^2 (or kg): so large that no force of the rig moves it.

A force of armature * acceleration then gives exactly that acceleration, whatever the
rig does: relative error = (rig's own force) / (armature * acceleration), below 1e-12.
That turns MuJoCo's forward dynamics into inverse dynamics, for some joints or for all.
"""

CARRIER, DUST = "_carrier", 1e-6  # kg, of a body between a segment and an IMU that slides on springs

SPRING_LAW, STOP_LAW = "joint_spring", "end_stop"
"""Names of numerics in an MJCF file; see `laws_of`."""
SEGMENT_SENSORS = ("framepos", "framequat", "framelinvel", "gyro", "framelinacc", "frameangacc")
IMU_SENSORS = ("framepos", "framequat", "framelinacc", "frameangacc", "accelerometer", "gyro")


def specify(rig: Rig, timestep: float = 1e-3, integrator: str = "implicitfast", watch_segments: bool = True) -> Any:
    """Return the MjSpec of a rig with sensors on its IMUs and, if so wanted, its segments and pictures."""
    spec = _template(rig.family, mjcf(rig.family), watch_segments).copy()
    spec.option.timestep = timestep
    spec.option.gravity = [0.0, 0.0, -rig.gravity]
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    segments = rig.tree.names
    for name, segment in zip(segments, rig.segments, strict=True):
        body = spec.body(name)
        for geom in body.geoms:
            geom.mass = 0.0  # a picture; the mass is the body's own
        body.explicitinertial = True
        body.mass, body.ipos, body.inertia = segment.mass, segment.com, segment.inertia
    set_joint(spec, rig)
    imus = rig.tree.imus[: len(rig.mounts)]
    for name, mount in zip(imus, rig.mounts, strict=True):
        _set_mount(spec, name, mount)
    for name in rig.tree.imus[len(rig.mounts) :]:
        spec.delete(spec.body(name))
    lighten(spec.body(segments[-1]), rig.inertia_scale)
    if rig.stop is not None or rig.loose is not None:
        spec.option.tolerance = 0.0  # soft limits beside large inertias: what the solver would gain looks like nothing
    if rig.stop is not None and rig.tree.hinge is not None:
        # MuJoCo takes a limit's stiffness by the joint's inverse inertia, which it knows once everything is there.
        model, joint = spec.compile(), spec.joint(rig.tree.hinge.name)
        light = float(model.dof_invweight0[model.joint(joint.name).dofadr[0]])
        joint.solref_limit = [-rig.stop.stiffness * light, -rig.stop.damping * light]
    _add_sensors(spec, segments if watch_segments else (), imus)
    _add_laws(spec, rig)
    return spec


@lru_cache
def _template(family: str, text: str, watch_segments: bool) -> Any:
    """Return the MjSpec of a family's MJCF file, to be copied; `text` is what the file holds now."""
    write_no_log()
    spec, imus = rig_spec(family), rig_tree(family).imus
    springs = [joint for name in imus for joint in spec.body(name).joints]
    for part in (*spec.sensors, *spec.equalities, *springs):
        spec.delete(part)  # for who opens the file; a simulation adds its own
    if not watch_segments:
        for part in (*spec.geoms, *(s for s in spec.sites if s.name not in imus)):
            spec.delete(part)  # pictures and unwatched places: time for nothing
    return spec


def compile_model(rig: Rig, timestep: float = 1e-3, integrator: str = "implicitfast", driven: str = "") -> Any:
    """Return the MjModel of a rig; `driven` is "" (nothing), "joints" (neither mounts nor play) or "all".

    Where joints are driven, the segments' motion is known, but for a play, and only the IMUs have sensors.
    """
    spec = specify(rig, timestep, integrator, watch_segments=not driven or rig.loose is not None)
    spec.compiler.fusestatic = driven == "all"  # a rigid IMU needs no body of its own there: fewer to compute
    model = spec.compile()
    if driven:
        _leave_to_the_driver(model, rig)
        dofs = [_is_mount_dof(model, i) for i in range(model.nv)]
        loose = [mount and driven == "joints" for mount in dofs]
        model.dof_armature[:] = np.where(loose, model.dof_armature, DRIVEN_ARMATURE)
        model.dof_damping[:] = np.where(loose, model.dof_damping, 0.0)
        model.dof_frictionloss[:] = model.dof_dampingpoly[:] = 0.0
        mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def _leave_to_the_driver(model: Any, rig: Rig) -> None:
    """Switch off what holds joints together or back, where a motion says where they are; a play keeps its stops."""
    flags = mujoco.mjtDisableBit
    if rig.loose is None:
        model.opt.disableflags |= int(flags.mjDSBL_CONSTRAINT)
        return
    model.opt.disableflags |= int(flags.mjDSBL_EQUALITY) | int(flags.mjDSBL_FRICTIONLOSS)
    model.jnt_limited[:] = [model.joint(i).name == PLAY for i in range(model.njnt)]


def mount_dofs(model: Any) -> np.ndarray:
    """Return the mask (nv,) of the degrees of freedom that follow by forces: those of sprung mounts and of play."""
    return np.array([_is_mount_dof(model, i) for i in range(model.nv)], dtype=bool)


def mount_positions(model: Any) -> np.ndarray:
    """Return the places (mounts,) of sprung mounts' joints in qpos, in the order of their degrees of freedom."""
    return np.asarray(model.jnt_qposadr[model.dof_jntid[mount_dofs(model)]], dtype=int)


def _is_mount_dof(model: Any, dof: int) -> bool:
    name = model.joint(model.dof_jntid[dof]).name
    return bool(name == PLAY or (name.startswith("imu") and "_path_" not in name))


def _set_mount(spec: Any, name: str, mount: Mount) -> None:
    """Put the IMU body's frame in the pivot and its site at the sensing point."""
    body = carrier = spec.body(name)
    if mount.slides and mount.sprung:
        body, carrier = _on_a_carrier(spec, name)
    carrier.pos = mount.position - rotations.rotate(mount.quaternion, mount.lever)
    carrier.quat = mount.quaternion
    body.explicitinertial = True
    body.mass, body.ipos = mount.mass, mount.com
    about_pivot = mount.mass * mount.gyration**2 * np.eye(3)
    com = mount.com
    inertia = about_pivot - mount.mass * (com @ com * np.eye(3) - np.outer(com, com))
    body.inertia = np.zeros(3)  # MuJoCo takes one of the two, and the file has this one
    body.fullinertia = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    for site in body.sites:
        site.pos = mount.lever
    for geom in body.geoms:
        geom.pos, geom.mass = mount.lever, 0.0
    segment_axes = rotations.rotate_back(mount.quaternion, np.eye(3))
    if mount.translation is not None:
        _add_springs(body, carrier, mount.translation, "slide", segment_axes, np.full(3, mount.mass))
    for name, vector in shifts(mount):
        axis = along(rotations.rotate_back(mount.quaternion, vector))
        joint = carrier.add_joint(name=f"{body.name}_path_{name}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        joint.armature = TINY_ARMATURE
    for name, rotation in turns(mount):
        joint = body.add_joint(name=f"{body.name}_path_{name}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=along(rotation))
        joint.armature = TINY_ARMATURE
    if mount.rotation is not None:
        _add_springs(body, body, mount.rotation, "hinge", np.eye(3), np.full(3, mount.mass * mount.gyration**2))


def _on_a_carrier(spec: Any, name: str) -> tuple[Any, Any]:
    """Return an IMU's body made anew on one of next to no mass, and that: MuJoCo gives a body six joints at most."""
    old = spec.body(name)
    parent, geom, site = old.parent, old.geoms[0] if old.geoms else None, old.sites[0]
    picture = None if geom is None else {key: getattr(geom, key) for key in ("type", "size", "rgba")}
    label = geom.name if geom is not None else ""
    spot = site.name
    spec.delete(old)
    carrier = parent.add_body(name=f"{name}{CARRIER}")
    carrier.explicitinertial, carrier.mass, carrier.inertia, carrier.ipos = True, DUST, [DUST * 1e-4] * 3, [0, 0, 0]
    body = carrier.add_body(name=name)
    if picture is not None:
        body.add_geom(name=label, **picture)
    body.add_site(name=spot)
    return body, carrier


def shifts(mount: Mount) -> list[tuple[str, np.ndarray]]:
    """Return name and vector (3,), segment axes, of the ways that a sliding mount goes."""
    found = list(zip("xyz", np.eye(3), strict=True)) if mount.path is not None else []
    slip = [("shift", mount.slip.translation)] if mount.slip is not None else []
    return found + [(name, vector) for name, vector in (*slip, ("slide", mount.slide)) if vector.any()]


def turns(mount: Mount) -> list[tuple[str, np.ndarray]]:
    """Return name and rotation vector (3,) of the turns that a sliding mount makes, one after the other."""
    found = [("slip", mount.slip.rotation)] if mount.slip is not None else []
    return [(name, vector) for name, vector in (*found, ("twist", mount.twist)) if vector.any()]


def _add_springs(body: Any, carrier: Any, spring: Any, kind: str, axes: np.ndarray, inertia: np.ndarray) -> None:
    w = 2 * np.pi * spring.frequency
    for i in range(3):
        joint = carrier.add_joint(name=f"{body.name}_{kind}_{'xyz'[i]}", axis=axes[i])
        joint.type = getattr(mujoco.mjtJoint, f"mjJNT_{kind.upper()}")
        joint.stiffness[0] = inertia[i] * w[i] ** 2
        joint.damping[0] = inertia[i] * 2 * spring.damping_ratio[i] * w[i]


def laws_of(rig: Rig) -> dict[str, list[float]]:
    """Return the numbers of what MuJoCo has no term for, by name: when a mount slips, what a ball joint's swing meets.

    imuN_slip: time s, translation (3) m, rotation (3) rad. imuN_slide, imuN_twist: (3) by rad of a pendulum's swing; on
    a hinge these are equalities. joint_spring: k N m/rad, q0 rad, whether it conserves. end_stop: angle rad, stiffness
    N m/rad, damping N m s/rad.
    """
    found = {}
    for n, mount in enumerate(rig.mounts, 1):
        if mount.slip is not None:
            found[f"imu{n}_slip"] = [mount.slip.time, *mount.slip.translation, *mount.slip.rotation]
        if rig.tree.ball is not None:
            found |= {f"imu{n}_{k}": list(v) for k, v in (("slide", mount.slide), ("twist", mount.twist)) if v.any()}
    if rig.tree.ball is not None and rig.stiffness:
        found[SPRING_LAW] = [rig.stiffness, rig.spring_angle, float(rig.spring_conserves)]
    if rig.tree.ball is not None and rig.stop is not None:
        found[STOP_LAW] = [rig.stop.angle, rig.stop.stiffness, rig.stop.damping]
    return {name: [float(x) for x in numbers] for name, numbers in found.items()}


def _add_laws(spec: Any, rig: Rig) -> None:
    """Write what MuJoCo has no term for into the model, and gear what slides with a hinge to that."""
    for name, numbers in laws_of(rig).items():
        spec.add_numeric(name=name, size=len(numbers), data=numbers)
    if rig.tree.hinge is None or rig.locked_at is not None:
        return
    for n, mount in enumerate(rig.mounts, 1):
        for name, vector in (("slide", mount.slide), ("twist", mount.twist)):
            if vector.any():
                gear(spec, rig.tree, f"imu{n}_path_{name}", float(np.linalg.norm(vector)))


def _add_sensors(spec: Any, segments: tuple[str, ...], imus: tuple[str, ...]) -> None:
    named = [(name, SEGMENT_SENSORS) for name in segments] + [(name, IMU_SENSORS) for name in imus]
    for site, kinds in named:
        for kind in kinds:
            spec.add_sensor(
                name=f"{site}_{kind}",
                type=getattr(mujoco.mjtSensor, f"mjSENS_{kind.upper()}"),
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=site,
            )
