"""A rig's numbers become a MuJoCo model (MjSpec), with the sensors that read the truth."""

from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

from imubench import rotations
from imubench.models import mjcf
from imubench.recording import RIGS
from imubench.sim.rigs import Mount, Rig
from imubench.sim.stability import write_no_log

DRIVEN_ARMATURE = 1e13
"""Inertia of a driven joint, kg m^2 (or kg): so large that no force of the rig moves it.

A force of armature * acceleration then gives exactly that acceleration, whatever the
rig does: relative error = (rig's own force) / (armature * acceleration), below 1e-12.
That turns MuJoCo's forward dynamics into inverse dynamics, for some joints or for all.
"""

SEGMENT_SENSORS = ("framepos", "framequat", "framelinvel", "gyro", "framelinacc", "frameangacc")
IMU_SENSORS = ("framepos", "framequat", "framelinacc", "frameangacc", "accelerometer", "gyro")


def specify(rig: Rig, timestep: float = 1e-3, integrator: str = "implicitfast", watch_segments: bool = True) -> Any:
    """Return the MjSpec of a rig with sensors on its IMUs and, if so wanted, its segments and pictures."""
    spec = _template(rig.family, watch_segments).copy()
    spec.option.timestep = timestep
    spec.option.gravity = [0.0, 0.0, -rig.gravity]
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    segments = RIGS[rig.family]
    for name, segment in zip(segments, rig.segments, strict=True):
        body = spec.body(name)
        for geom in body.geoms:
            geom.mass = 0.0  # a picture; the mass is the body's own
        body.explicitinertial = True
        body.mass, body.ipos, body.inertia = segment.mass, segment.com, segment.inertia
    _set_joint(spec, rig)
    for i, mount in enumerate(rig.mounts):
        _set_mount(spec.body(f"imu{i + 1}"), mount)
    for name in segments[len(rig.mounts) :]:
        spec.delete(spec.body(name.replace("segment", "imu")))
    _add_sensors(spec, segments if watch_segments else (), len(rig.mounts))
    return spec


@lru_cache
def _template(family: str, watch_segments: bool) -> Any:
    """Return the MjSpec of a family's MJCF file, to be copied."""
    write_no_log()
    spec = mujoco.MjSpec.from_string(mjcf(family))
    if not watch_segments:
        for part in (*spec.geoms, *(s for s in spec.sites if not s.name.startswith("imu"))):
            spec.delete(part)  # pictures and unwatched places: time for nothing
    return spec


def compile_model(rig: Rig, timestep: float = 1e-3, integrator: str = "implicitfast", driven: str = "") -> Any:
    """Return the MjModel of a rig; `driven` is "" (nothing), "joints" (not the mounts) or "all".

    Where joints are driven, the segments' motion is known, and only the IMUs have sensors.
    """
    spec = specify(rig, timestep, integrator, watch_segments=not driven)
    spec.compiler.fusestatic = driven == "all"  # a rigid IMU needs no body of its own there: fewer to compute
    model = spec.compile()
    if driven:
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        dofs = [_is_mount_dof(model, i) for i in range(model.nv)]
        model.dof_armature[:] = [0.0 if mount and driven == "joints" else DRIVEN_ARMATURE for mount in dofs]
        model.dof_damping[:] = np.where(model.dof_armature > 0, 0.0, model.dof_damping)
        model.dof_frictionloss[:] = model.dof_dampingpoly[:] = 0.0
        mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def mount_dofs(model: Any) -> np.ndarray:
    """Return the mask (nv,) of the degrees of freedom that belong to sprung mounts."""
    return np.array([_is_mount_dof(model, i) for i in range(model.nv)], dtype=bool)


def mount_positions(model: Any) -> np.ndarray:
    """Return the places (mounts,) of sprung mounts' joints in qpos, in the order of their degrees of freedom."""
    return np.asarray(model.jnt_qposadr[model.dof_jntid[mount_dofs(model)]], dtype=int)


def _is_mount_dof(model: Any, dof: int) -> bool:
    name = model.joint(model.dof_jntid[dof]).name
    return bool(name.startswith("imu") and "_path_" not in name)


def _set_joint(spec: Any, rig: Rig) -> None:
    if rig.family == "hinge" and rig.base == "fixed":
        spec.delete(spec.joint("base"))
        spec.body("segment1").quat = rig.base_quaternion
    if rig.pivot_moves:
        _carry(spec)
    joint = spec.joint("hinge" if rig.family == "hinge" else "base")
    if rig.family == "free":
        return
    joint.damping[0] = rig.damping
    if rig.family == "hinge":
        joint.damping[1], joint.stiffness[0] = rig.drag, rig.stiffness
        joint.springref = np.rad2deg(rig.spring_angle) if spec.compiler.degree else rig.spring_angle
    joint.frictionloss = rig.dry_friction
    joint.solref_friction = [
        2 * spec.option.timestep,
        1.0,
    ]  # turns over as fast as a step allows: MuJoCo's own is 20 ms
    if rig.locked_at is not None:
        spec.delete(joint)
        spec.body("segment2").quat = rotations.exp(np.array([0.0, rig.locked_at, 0.0]))


def _carry(spec: Any) -> None:
    """Put slides along the world's axes before a pendulum's ball joint."""
    spec.delete(spec.joint("base"))
    for axis, letter in zip(np.eye(3), "xyz", strict=True):
        spec.body("segment1").add_joint(name=f"pivot_{letter}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    spec.body("segment1").add_joint(name="base", type=mujoco.mjtJoint.mjJNT_BALL)


def _set_mount(body: Any, mount: Mount) -> None:
    """Put the IMU body's frame in the pivot and its site at the sensing point."""
    body.pos = mount.position - rotations.rotate(mount.quaternion, mount.lever)
    body.quat = mount.quaternion
    body.explicitinertial = True
    body.mass, body.ipos = mount.mass, mount.com
    about_pivot = mount.mass * mount.gyration**2 * np.eye(3)
    com = mount.com
    inertia = about_pivot - mount.mass * (com @ com * np.eye(3) - np.outer(com, com))
    body.fullinertia = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    for site in body.sites:
        site.pos = mount.lever
    for geom in body.geoms:
        geom.pos, geom.mass = mount.lever, 0.0
    segment_axes = rotations.rotate_back(mount.quaternion, np.eye(3))
    if mount.translation is not None:
        _add_springs(body, mount.translation, "slide", segment_axes, np.full(3, mount.mass))
    if mount.slides:
        for axis, letter in zip(segment_axes, "xyz", strict=True):
            body.add_joint(name=f"{body.name}_path_{letter}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        for name, rotation in turns(mount):
            body.add_joint(name=f"{body.name}_path_{name}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=rotation)
    if mount.rotation is not None:
        _add_springs(body, mount.rotation, "hinge", np.eye(3), np.full(3, mount.mass * mount.gyration**2))


def turns(mount: Mount) -> list[tuple[str, np.ndarray]]:
    """Return name and rotation vector (3,) of the turns that a sliding mount makes, one after the other."""
    found = [("slip", mount.slip.rotation)] if mount.slip is not None else []
    return [(name, vector) for name, vector in (*found, ("twist", mount.twist)) if vector.any()]


def _add_springs(body: Any, spring: Any, kind: str, axes: np.ndarray, inertia: np.ndarray) -> None:
    w = 2 * np.pi * spring.frequency
    for i in range(3):
        joint = body.add_joint(name=f"{body.name}_{kind}_{'xyz'[i]}", axis=axes[i])
        joint.type = getattr(mujoco.mjtJoint, f"mjJNT_{kind.upper()}")
        joint.stiffness[0] = inertia[i] * w[i] ** 2
        joint.damping[0] = inertia[i] * 2 * spring.damping_ratio[i] * w[i]


def _add_sensors(spec: Any, segments: tuple[str, ...], imus: int) -> None:
    named = [(name, SEGMENT_SENSORS) for name in segments] + [(f"imu{i + 1}", IMU_SENSORS) for i in range(imus)]
    for site, kinds in named:
        for kind in kinds:
            spec.add_sensor(
                name=f"{site}_{kind}",
                type=getattr(mujoco.mjtSensor, f"mjSENS_{kind.upper()}"),
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=site,
            )
