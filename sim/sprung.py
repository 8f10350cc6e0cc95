"""Sprung mounts and loose limbs: forward dynamics of what hangs on segments that do what they are told.

MuJoCo's Runge-Kutta integrator takes steps of order 4, with one force, hence one acceleration, of each driven joint
throughout a step. Driven rates are then lines from step to step. Through the true rates w[k] these lines would
enclose an area that is off by h^3 w'' / 12; through

    u[k] = w[k] - (w[k+1] - 2 w[k] + w[k-1]) / 12

it is right to h^5: segments stay where they are told, and mounts feel what the motion does to them, to order 4.
At the steps themselves segments then turn and move with u instead of w. A jolt from the one to the other gives the
mounts the velocities relative to the segments that belong to w. A play gets none: its steps are so short (`KNOCKING`)
that u and w differ by less than what a stop's own stiffness makes of them.
"""

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, fields, replace
from typing import Any

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from imubench import rotations
from imubench.arrays import Array
from imubench.errors import InputError
from imubench.sim.compile import DRIVEN_ARMATURE, mount_dofs, mount_positions
from imubench.sim.driven import joint_state
from imubench.sim.joint_model import PLAY, loose_inertia
from imubench.sim.joints import Play
from imubench.sim.jolt import jolted
from imubench.sim.kinematics import segments_of
from imubench.sim.motion import Motion, Trajectory
from imubench.sim.rigs import Rig
from imubench.sim.signals import Signal
from imubench.truth import SegmentTruth

CHUNK = 4096  # integration steps at once: memory does not grow with the duration, and stays in the cache
STEPS = 8  # a period of the fastest mode, if nothing else is said
LIGHT = 0.005, 0.05  # damping ratios between which lighter dampers take smaller steps
SLOWEST = 1e-6  # rad/s, of a mode that is one
LONGEST_STEP = 5e-3  # s: a motion's own bandwidth is not known; at 20 Hz this leaves some 1e-3 of the response
SHORTEST_STEP = 1e-5  # s: modes of 4 kHz and more; a tenth of that is rigid to any IMU
KNOCKING = 5e-4  # s, the longest step beside a play: 50 to a period of a limb on its stop, and u - w < 1e-4 rad/s
BRIEF = 1e-4  # s, for the rate of a load
MOST_TURN = 1.4  # rad, about each axis: beyond, a linear rotational spring means nothing and its axes line up


class UnheldSensorError(InputError):
    """Springs do not hold their sensor: a rig that cannot be played, which a study of many can count."""


def sprung_motion(
    rig: Rig, model: Any, motion: Motion, count: int, rate: float, longest: float | None = None
) -> tuple[Array, Array, Trajectory]:
    """Return displacement and velocity of every joint that follows at k / rate s, k < `count`, each (count, joints).

    The third is the trajectory at those times. `model` is that of the rig with its joints driven; `longest` is the
    longest step in s, None: the default.
    Raises `UnheldSensorError` where springs do not hold the sensor, `InputError` where they are too quick to integrate.
    """
    stepping = stepping_model(model, rate, longest)
    split = round(1.0 / (rate * stepping.opt.timestep))
    parts = list(_chunks(rig, stepping, motion, (count - 1) * split, split, rate))
    positions, velocities, trajectories = zip(*parts, strict=True)
    joined = {f.name: np.concatenate([getattr(t, f.name) for t in trajectories]) for f in fields(Trajectory)}
    return np.concatenate(positions), np.concatenate(velocities), Trajectory(**joined)


def stepping_model(model: Any, rate: float, longest: float | None = None) -> Any:
    """Return the model as its mounts are integrated, with a timestep that goes a whole number of times in 1 / rate."""
    model = copy(model)
    model.opt.integrator = int(mujoco.mjtIntegrator.mjINT_RK4)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
    if longest is None:
        longest = _default_step(model)
        if not longest >= SHORTEST_STEP:  # NaN where numbers overflow
            raise InputError(
                "sprung mount: expected springs and dampers that are integrated in steps of "
                f"{SHORTEST_STEP:g} s or more, got {longest:.2g} s"
            )
    model.opt.timestep = 1.0 / (rate * int(np.ceil(1.0 / (rate * longest) - 1e-9)))
    return model


def _default_step(model: Any) -> float:
    """Return the longest step, s, by the mounts' modes about their unloaded place.

    The integrator's error a period is in h^4; a mode rings for 1 / damping ratio periods, over which they add up.
    """
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, state, mass)
    dofs = mount_dofs(model)
    mass = mass[np.ix_(dofs, dofs)]
    stiffness = [np.ravel(model.jnt_stiffness[j])[0] for j in model.dof_jntid[dofs]]
    damping = model.dof_damping[dofs]
    still = np.zeros_like(mass)
    a, b = np.linalg.solve(mass, np.diag(stiffness)), np.linalg.solve(mass, np.diag(damping))
    modes = np.linalg.eigvals(np.block([[still, np.eye(len(mass))], [-a, -b]]))
    knocks = any(model.joint(j).name == PLAY for j in model.dof_jntid[dofs])
    modes = modes[np.abs(modes) > SLOWEST]  # a free play has none
    ratio = np.clip(-modes.real / np.abs(modes), *LIGHT)
    steps = STEPS * (LIGHT[1] / ratio) ** 0.5
    most = KNOCKING if knocks else LONGEST_STEP
    return float((2 * np.pi / (steps * np.abs(modes))).min(initial=most))


def _chunks(
    rig: Rig, model: Any, motion: Motion, steps: int, split: int, rate: float
) -> Iterator[tuple[Array, Array, Trajectory]]:
    """Yield positions and velocities (m, mounts) and the trajectory at every `split`-th step, from 0 to the last."""
    h, per_second, dofs, columns = model.opt.timestep, rate * split, mount_dofs(model), mount_positions(model)
    spec = int(mujoco.mjtState.mjSTATE_QFRC_APPLIED)
    batch = mujoco_batch.Batch(model, nsim=1, nthread=1)
    size = split * max(1, CHUNK // split)
    x = v = np.empty((0, columns.size))
    for start in range(0, max(steps, 1), size):
        end = min(start + size, steps)
        told = motion(np.arange(start - 1, end + 2, dtype=float) / per_second)
        qpos, w, _ = joint_state(rig, model, told)
        qpos, u = qpos[1:-1], w[1:-1] - np.diff(w, 2, axis=0) / 12
        if start == 0:
            x, v = _at_rest(rig, motion, _lag(told, slice(0, 1)), h)
        qpos[0, columns], u[0, dofs] = x[-1], v[-1]
        if end > start:
            batch.bind("qpos")[:], batch.bind("qvel")[:] = qpos[0], u[0]
            force = DRIVEN_ARMATURE * np.diff(np.where(dofs, 0.0, u), axis=0) / h
            out = batch.rollout(end - start, control=force[None], control_spec=spec, record=("qpos", "qvel"))
            qpos[1:, columns], u[1:, dofs] = out["qpos"][0][:, columns], out["qvel"][0][:, dofs]
            _check_held(model, qpos[:, columns], bool(batch.bind("time")[0] > (end - 0.5) * h))
        x, v = qpos[:, columns], u[:, dofs]
        at = slice(0, None if end == steps else -1, split)
        yield x[at], _jolted(_lagging(rig, h), _lag(told, at), x[at], v[at]), _inner(told, at)


def _lag(told: Trajectory, at: slice) -> Trajectory:
    """Return a trajectory whose rates are w - u, at rows of `told` without its first and last."""
    rates = {key: np.diff(getattr(told, key), 2, axis=0)[at] / 12 for key in ("velocity", "rate", "angle_rate")}
    return replace(_inner(told, at), **rates)


@dataclass(frozen=True)
class _LagOf:
    """A signal whose rate is w - u, times a factor; see `_lag`."""

    signal: Signal
    step: float  # s
    times: float

    def __call__(self, time: Array) -> tuple[Array, Array, Array]:
        value, rate, second = self.signal(time)
        before, after = (self.signal(time + shift)[1] for shift in (-self.step, self.step))
        return value, self.times * (after - 2 * rate + before) / 12, second


def _lagging(rig: Rig, step: float, times: float = 1.0) -> Rig:
    """Return a rig whose play, where it is told, has the rates w - u, times a factor."""
    if rig.play is None or rig.play.path is None:
        return rig
    one, other = (_LagOf(signal, step, times) for signal in rig.play.path)
    return replace(rig, play=replace(rig.play, path=(one, other)))


def _inner(told: Trajectory, at: slice) -> Trajectory:
    """Return rows of a trajectory without its first and last."""
    return Trajectory(**{f.name: getattr(told, f.name)[1:-1][at] for f in fields(told)})


def _jolted(rig: Rig, change: Trajectory, x: Array, v: Array) -> Array:
    """Return the mounts' velocities (n, mounts) after the rates of all segments changed by those of `change`."""
    after = v.copy()
    for mount, own, segment in zip(rig.mounts, rig.spring_columns, segments_of(rig, change), strict=False):
        if mount.sprung:
            after[:, own] = jolted(mount, segment, x[:, own], v[:, own])
    return after


def _at_rest(rig: Rig, motion: Motion, lag: Trajectory, step: float) -> tuple[Array, Array]:
    """Return positions and velocities (1, mounts) whose springs balance the load at time 0, for driven rates u."""
    before, at, after = _resting(rig, motion, np.array([-BRIEF, 0.0, BRIEF]))
    rates = (after - before) / (2 * BRIEF)
    if rig.loose is not None:
        rates[rig.play_column] = 0.0  # it leans on its stops
    back = replace(lag, velocity=-lag.velocity, rate=-lag.rate, angle_rate=-lag.angle_rate)
    return at[None], _jolted(_lagging(rig, step, -1.0), back, at[None], rates[None])


def _resting(rig: Rig, motion: Motion, time: Array) -> Array:
    """Return the mount joints' deflections (n, mounts) that balance the load at `time`, as very stiff springs would."""
    deflections = []
    gravity_w = np.array([0.0, 0.0, -rig.gravity])
    for n, (mount, segment) in enumerate(zip(rig.mounts, segments_of(rig, motion(time)), strict=False)):
        if n == 1 and rig.loose is not None:
            deflections.append(_leaning(rig, rig.loose, segment, gravity_w)[:, None])
        w, alpha, p = segment.rate, segment.angular_acceleration, mount.position
        felt = rotations.rotate_back(segment.quaternion, segment.acceleration - gravity_w)
        load = -(felt + np.cross(alpha, p) + np.cross(w, np.cross(w, p)))  # per unit mass, segment axes
        if mount.translation is not None:
            deflections.append(load / (2 * np.pi * mount.translation.frequency) ** 2)
        if mount.rotation is not None:
            load, alpha = (rotations.rotate_back(mount.quaternion, v) for v in (load, alpha))
            drive = np.cross(mount.com, load) / mount.gyration**2 - alpha
            deflections.append(drive / (2 * np.pi * mount.rotation.frequency) ** 2)
    return np.concatenate(deflections, axis=-1)


def _leaning(rig: Rig, play: Play, segment: SegmentTruth, gravity_w: Array) -> Array:
    """Return where a loose limb (n,) rad rests: where its springs balance its load, or on a stop."""
    felt = rotations.rotate_back(segment.quaternion, segment.acceleration - gravity_w)
    own = rig.segments[-1]
    com, whole = own.mass * own.com / rig.inertia_scale, loose_inertia(rig) / play.share
    about = np.diag(own.inertia) + own.mass * (own.com @ own.com * np.eye(3) - np.outer(own.com, own.com))
    turned = segment.angular_acceleration @ about / rig.inertia_scale
    load = -(turned + np.cross(com, felt)) @ play.axis / whole
    return np.clip(load / max((2 * np.pi * play.frequency) ** 2, 1e-9), -play.range, play.range)


def _check_held(model: Any, positions: Array, went_through: bool) -> None:
    """Raise `UnheldSensorError` where a mount turns further than springs can, or MuJoCo had to begin anew."""
    turns = model.jnt_type[model.dof_jntid[mount_dofs(model)]] == mujoco.mjtJoint.mjJNT_HINGE
    most = float(np.abs(positions[:, turns]).max(initial=0.0))
    if not went_through or not most <= MOST_TURN:
        found = f"{most:.1f} rad" if went_through else "one that is thrown about"
        expected = f"springs that hold the sensor within {MOST_TURN:g} rad"
        raise UnheldSensorError(f"sprung mount: expected {expected}, got {found}")
