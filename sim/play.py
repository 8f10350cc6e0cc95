"""Prescribed motion: segments (and sensors on a path) do what they are told; sprung sensors follow as they must.

Segments are driven (see `compile.DRIVEN_ARMATURE`), so MuJoCo solves inverse dynamics for
them and forward dynamics for the mounts, in one model. The mounts are integrated by a
leapfrog: positions at the steps, velocities half-way between,

    v[k+1/2] = v[k-1/2] + h a(x[k], v),    x[k+1] = x[k] + h v[k+1/2],

of second order in the springs and of first order in dampers and inertial forces, whose
velocities lag by half a step. Driven joints follow the same scheme, with velocities that land on the
prescribed positions exactly. What a sensor reads is then evaluated once more, with every
joint driven by its true rate and acceleration.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from imubench import rotations
from imubench.arrays import Array
from imubench.recording import positive
from imubench.sim.compile import DRIVEN_ARMATURE, compile_model, mount_dofs
from imubench.sim.motion import Motion, Trajectory
from imubench.sim.readout import read_truth
from imubench.sim.rigs import Rig
from imubench.sim.signals import Signal
from imubench.truth import Truth

CHUNK = 8192  # samples handed to MuJoCo at once; its state rows then stay in the cache
FINE_CHUNK = 4096  # integration steps of sprung mounts at once


def play(
    rig: Rig,
    motion: Motion,
    duration: float,
    rate: float = 1000.0,
    step: float | None = None,
    labels: tuple[tuple[str, float, float], ...] = (),
    threads: int = 0,
) -> Truth:
    """Return the truth of a prescribed motion, `rate` samples a second for `duration` s.

    `step` is the longest integration step of sprung mounts in s; None takes a 200th of the
    fastest spring's period. `threads` 0 uses every core; the result does not depend on it.
    """
    positive(duration, "duration")
    positive(rate, "rate")
    time = np.arange(round(duration * rate)) / rate
    model = compile_model(rig, driven="all")
    mounts = None
    if rig.sprung:
        mounts = _sprung_mounts(rig, motion, time, rate, step or _default_step(rig))
    trajectory = motion(time)
    state = joint_state(rig, model, trajectory, mounts)
    return read_truth(rig, model, time, evaluate(model, *state, threads=threads), labels, trajectory)


def evaluate(model: Any, qpos: Array, qvel: Array, qacc: Array, threads: int = 0) -> Array:
    """Return the sensor data (n, nsensordata) of joints that are driven through these states."""
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
    rig: Rig, model: Any, trajectory: Trajectory, mounts: tuple[Array, Array, Array] | None = None
) -> tuple[Array, Array, Array]:
    """Return MuJoCo's qpos (n, nq), qvel and qacc (n, nv) of a trajectory; mounts rest where none are given."""
    n = trajectory.time.size
    qpos, qvel, qacc = np.zeros((n, model.nq)), np.zeros((n, model.nv)), np.zeros((n, model.nv))
    names = {model.joint(i).name for i in range(model.njnt)}
    if "base" in names:
        joint = model.joint("base")
        p, v = int(joint.qposadr[0]), int(joint.dofadr[0])
        if rig.family != "pendulum":
            qpos[:, p : p + 3], qvel[:, v : v + 3] = trajectory.position, trajectory.velocity
            qacc[:, v : v + 3] = trajectory.acceleration
            p, v = p + 3, v + 3
        qpos[:, p : p + 4], qvel[:, v : v + 3] = trajectory.quaternion, trajectory.rate
        qacc[:, v : v + 3] = trajectory.angular_acceleration
    if "hinge" in names:
        p, v = int(model.joint("hinge").qposadr[0]), int(model.joint("hinge").dofadr[0])
        qpos[:, p], qvel[:, v], qacc[:, v] = trajectory.angle, trajectory.angle_rate, trajectory.angle_acceleration
    for name, signal, felt in _paths(rig):
        p, v = int(model.joint(name).qposadr[0]), int(model.joint(name).dofadr[0])
        qpos[:, p], rate, acceleration = signal(trajectory.time)
        if felt:
            qvel[:, v], qacc[:, v] = rate, acceleration
    if mounts is not None:
        dofs = mount_dofs(model)
        qpos[:, _mount_positions(model, dofs)], qvel[:, dofs], qacc[:, dofs] = mounts
    return qpos, qvel, qacc


def _paths(rig: Rig) -> Iterator[tuple[str, Signal, bool]]:
    """Yield joint name, signal and whether it is felt, for every prescribed slide of a mount."""
    for i, mount in enumerate(rig.mounts):
        for signal, letter in zip(mount.path or (), "xyz", strict=False):
            yield f"imu{i + 1}_path_{letter}", signal, mount.path_felt


def _mount_positions(model: Any, dofs: Array) -> Array:
    return np.array([model.jnt_qposadr[model.dof_jntid[i]] for i in np.flatnonzero(dofs)], dtype=int)


def _default_step(rig: Rig) -> float:
    springs = [s for m in rig.mounts for s in (m.translation, m.rotation) if s is not None]
    return 1.0 / (200 * max(float(s.frequency.max()) for s in springs))


def _sprung_mounts(rig: Rig, motion: Motion, time: Array, rate: float, longest: float) -> tuple[Array, Array, Array]:
    """Return displacement, velocity and acceleration of every mount joint at `time`, each (n, mounts).

    The steps are taken in chunks: memory does not grow with the duration, and stays in the cache.
    """
    split = int(np.ceil(1.0 / (rate * longest) - 1e-9))
    h = 1.0 / (rate * split)
    model = compile_model(rig, timestep=h, driven="joints")
    dofs = mount_dofs(model)
    columns = _mount_positions(model, dofs)
    spec = int(mujoco.mjtState.mjSTATE_QFRC_APPLIED)
    batch = mujoco_batch.Batch(model, nsim=1, nthread=1)
    states = []
    last_x, last_v = np.empty((1, 0)), np.empty((1, 0))
    steps, size = (time.size - 1) * split + 1, split * max(1, FINE_CHUNK // split)
    for start in range(0, steps, size):
        end = min(start + size, steps)
        fine: Array = h * np.arange(start - 1, end + 1, dtype=float)  # one step early, for the first velocity
        qpos = joint_state(rig, model, motion(fine))[0]
        velocity = _velocity_between(model, qpos, h)
        if start == 0:
            resting = _resting_springs(rig, motion, fine[:2])
            qpos[1, columns], velocity[0, dofs] = resting[1], (resting[1] - resting[0]) / h
            batch.bind("qpos")[:], batch.bind("qvel")[:] = qpos[1], velocity[0]
            last_x, last_v = qpos[1:2], velocity[:1]
        force = DRIVEN_ARMATURE * np.diff(velocity, axis=0) / h
        force[:, dofs] = 0.0
        out = batch.rollout(end - start, control=force[None], control_spec=spec, record=("qpos", "qvel"))
        x, v = np.concatenate([last_x, out["qpos"][0]]), np.concatenate([last_v, out["qvel"][0]])
        last_x, last_v = x[-1:], v[-1:]
        x, v = x[:-1, columns], v[:, dofs]  # v[k] lies half a step before x[k]
        at = slice(0, None, split)
        states.append((x[at], ((v[1:] + v[:-1]) / 2)[at], (np.diff(v, axis=0) / h)[at]))
    displacement, rates, accelerations = (np.concatenate(parts) for parts in zip(*states, strict=True))
    return displacement, rates, accelerations


def _velocity_between(model: Any, qpos: Array, h: float) -> Array:
    """Return the velocities (n - 1, nv) that lead from each row of qpos (n, nq) to the next in h s."""
    velocity = np.zeros((len(qpos) - 1, model.nv))
    for i in range(model.njnt):
        p, v, kind = int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i]), int(model.jnt_type[i])
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            velocity[:, v : v + 3] = np.diff(qpos[:, p : p + 3], axis=0) / h
            p, v = p + 3, v + 3
        if kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL):
            q = qpos[:, p : p + 4]
            velocity[:, v : v + 3] = rotations.log(rotations.multiply(rotations.conjugate(q[:-1]), q[1:])) / h
        else:
            velocity[:, v] = np.diff(qpos[:, p]) / h
    return velocity


def _resting_springs(rig: Rig, motion: Motion, time: Array) -> Array:
    """Return the mount joints' deflections (n, mounts) that balance the load at `time`, as very stiff springs would."""
    rigid = replace(rig, mounts=tuple(replace(m, translation=None, rotation=None) for m in rig.mounts))
    model = compile_model(rigid, driven="all")
    trajectory = motion(time)
    data = evaluate(model, *joint_state(rigid, model, trajectory))
    truth = read_truth(rigid, model, time, data, played=trajectory)
    deflections = []
    for mount, sensor in zip(rig.mounts, truth.sensors, strict=True):
        load = -sensor.specific_force  # per unit mass, sensor axes
        if mount.translation is not None:
            stiffness = (2 * np.pi * mount.translation.frequency) ** 2
            deflections.append(rotations.rotate(mount.quaternion, load) / stiffness)
        if mount.rotation is not None:
            drive = np.cross(mount.com, load) / mount.gyration**2 - sensor.angular_acceleration
            deflections.append(drive / (2 * np.pi * mount.rotation.frequency) ** 2)
    return np.concatenate(deflections, axis=-1)
