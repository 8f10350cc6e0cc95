"""Driven joints: states that a motion prescribes go into MuJoCo, sensor readings come out, many samples at once."""

from collections.abc import Collection, Iterator
from typing import Any

import numpy as np
from mujoco import batch as mujoco_batch

from imubench.arrays import Array
from imubench.effects.mounts import slipped
from imubench.jets import Jet
from imubench.sim.compile import DRIVEN_ARMATURE, mount_dofs, mount_positions, shifts, turns
from imubench.sim.joint_model import TOLD_PLAY
from imubench.sim.kinematics import hinge_of, turned
from imubench.sim.motion import Trajectory
from imubench.sim.rigs import Mount, Rig

CHUNK = 512  # samples handed to MuJoCo at once: their state rows stay in the cache, a fifth of the time of 8192


def evaluate(model: Any, qpos: Array, qvel: Array, qacc: Array, threads: int = 0) -> Array:
    """Return the sensor data (n, nsensordata) of joints that are driven through these states.

    Mounts that are not driven take the acceleration that their springs give them; `qacc` has zeros for those.
    """
    n = len(qpos)
    sensordata = np.empty((n, model.nsensordata))
    size = min(CHUNK, n)
    batch = mujoco_batch.Batch(model, nsim=size, nthread=threads)
    pos, vel, force, out = (batch.bind(k) for k in ("qpos", "qvel", "qfrc_applied", "sensordata"))
    for start in range(0, n, size):
        part = slice(min(start, n - size), min(start, n - size) + size)
        pos[:], vel[:] = qpos[part], qvel[part]
        np.multiply(qacc[part], DRIVEN_ARMATURE, out=force)
        batch.forward()
        sensordata[part] = out
    return sensordata


def joint_state(
    rig: Rig, model: Any, trajectory: Trajectory, mounts: tuple[Array, Array] | None = None
) -> tuple[Array, Array, Array]:
    """Return MuJoCo's qpos (n, nq), qvel and qacc (n, nv) of a trajectory.

    `mounts` are the positions and velocities of what follows by forces (sprung mounts, a play), each (n, mounts); it
    rests where none are given.
    """
    n = trajectory.time.size
    qpos, qvel, qacc = np.zeros((n, model.nq)), np.zeros((n, model.nv)), np.zeros((n, model.nv))
    names = {model.joint(i).name for i in range(model.njnt)}
    base, hinge = rig.tree.base, rig.tree.hinge
    if base is not None and base.name in names:
        joint = model.joint(base.name)
        p, v = int(joint.qposadr[0]), int(joint.dofadr[0])
        if rig.tree.floats:
            qpos[:, p : p + 3], qvel[:, v : v + 3] = trajectory.position, trajectory.velocity
            qacc[:, v : v + 3] = trajectory.acceleration
            p, v = p + 3, v + 3
        qpos[:, p : p + 4], qvel[:, v : v + 3] = trajectory.quaternion, trajectory.rate
        qacc[:, v : v + 3] = trajectory.angular_acceleration
    for i, letter in enumerate("xyz" if rig.pivot_moves else ""):
        p, v = int(model.joint(f"pivot_{letter}").qposadr[0]), int(model.joint(f"pivot_{letter}").dofadr[0])
        qpos[:, p], qvel[:, v] = trajectory.position[:, i], trajectory.velocity[:, i]
        qacc[:, v] = trajectory.acceleration[:, i]
    if hinge is not None and hinge.name in names:
        p, v = int(model.joint(hinge.name).qposadr[0]), int(model.joint(hinge.name).dofadr[0])
        qpos[:, p], qvel[:, v], qacc[:, v] = trajectory.angle, trajectory.angle_rate, trajectory.angle_acceleration
    for name, gear in _geared(rig, names):
        p, v = int(model.joint(name).qposadr[0]), int(model.joint(name).dofadr[0])
        qpos[:, p], qvel[:, v], qacc[:, v] = (gear * x for x in hinge_of(rig, trajectory))
    if rig.play is not None and rig.play.path is not None:
        for name, signal in zip(TOLD_PLAY, rig.play.path, strict=True):
            p, v = int(model.joint(name).qposadr[0]), int(model.joint(name).dofadr[0])
            qpos[:, p], qvel[:, v], qacc[:, v] = signal(trajectory.time)
    for name, (value, rate, acceleration), felt in _paths(rig, trajectory):
        p, v = int(model.joint(name).qposadr[0]), int(model.joint(name).dofadr[0])
        qpos[:, p] = value
        if felt:
            qvel[:, v], qacc[:, v] = rate, acceleration
    if mounts is not None:
        qpos[:, mount_positions(model)], qvel[:, mount_dofs(model)] = mounts
    return qpos, qvel, qacc


def _geared(rig: Rig, names: Collection[str]) -> Iterator[tuple[str, float]]:
    """Yield name and gear of every joint that follows the hinge, where it is there."""
    gears = zip(("coupling_x", "coupling_z", "centre"), (*rig.coupling, np.linalg.norm(rig.centre)), strict=True)
    yield from ((name, float(gear)) for name, gear in gears if name in names)


def _paths(rig: Rig, trajectory: Trajectory) -> Iterator[tuple[str, tuple[Array, Array, Array], bool]]:
    """Yield joint name, course with its derivatives, and whether it is felt, of every joint of a sliding mount."""
    for n, mount in enumerate(rig.mounts, 1):
        if not mount.slides:
            continue
        angle, step = turned(rig, trajectory), _slipped(mount, trajectory.time)
        told = dict(zip("xyz", mount.path or (), strict=False))
        for name, vector in (*shifts(mount), *turns(mount)):
            course = told[name](trajectory.time) if name in told else step if name in ("shift", "slip") else angle
            first, second, third = (np.linalg.norm(vector) * x for x in course)
            yield f"imu{n}_path_{name}", (first, second, third), mount.path_felt


def _slipped(mount: Mount, time: Array) -> tuple[Array, Array, Array]:
    """Return how far (0 to 1) a mount has slipped at `time` (n,) s, and the derivatives."""
    if mount.slip is None:
        still = np.zeros(time.size)
        return still, still, still
    value, rate, second = slipped(Jet(time[:, None]), Jet(np.full((1, 1), mount.slip.time)))
    return value.value[:, 0], rate.value[:, 0], second.value[:, 0]
