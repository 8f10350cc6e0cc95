"""Forward dynamics: a rig moves under gravity, friction and applied torques.

MuJoCo reports the sensors of the state *before* a step, which is why one step more than there
are samples is taken and sample k is read from the record of step k. Without sprung mounts the
integrator is Runge-Kutta of order 4; with them it is MuJoCo's `implicitfast`, of order 1, which
stiff dampers do not upset.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from imubench.arrays import Array, frozen, frozen_quaternion
from imubench.errors import InputError
from imubench.models.tree import Tree
from imubench.recording import positive
from imubench.sim.ball import needs_ball, swing_ball
from imubench.sim.compile import compile_model
from imubench.sim.readout import read_truth
from imubench.sim.rigs import Rig
from imubench.sim.stability import check_stable
from imubench.truth import Truth

BLOCK = 16  # rigs simulated at once: enough for every core, little enough for the memory

Torque = Callable[[Array], Array]
"""Takes times (n,) in s; returns N m: (n,) about the hinge, (n, 3) in segment axes on the ball joint."""


@dataclass(frozen=True)
class Start:
    """The state a swing starts from."""

    angle: float = 0.0  # rad, hinge
    angle_rate: float = 0.0  # rad/s
    position: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m, world; free base only
    velocity: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m/s, world
    quaternion: Array = field(default_factory=lambda: np.array([1.0, 0, 0, 0]))  # segment 1 -> world
    rate: Array = field(default_factory=lambda: np.zeros(3))  # (3,) rad/s, segment axes

    def __post_init__(self) -> None:
        for key in ("position", "velocity", "rate"):
            object.__setattr__(self, key, frozen(getattr(self, key), (3,), f"start.{key}"))
        object.__setattr__(self, "quaternion", frozen_quaternion(self.quaternion, "start.quaternion"))


def swing(
    rig: Rig,
    start: Start,
    duration: float,
    rate: float = 1000.0,
    torque: Torque | None = None,
    step: float = 1e-3,
) -> Truth:
    """Return the truth of one swing, `rate` samples a second for `duration` s, steps of at most `step` s."""
    return next(iter(swing_many([rig], [start], duration, rate, torque, step)))


def swing_many(
    rigs: Sequence[Rig],
    starts: Sequence[Start],
    duration: float,
    rate: float = 1000.0,
    torque: Torque | None = None,
    step: float = 1e-3,
    threads: int = 0,
) -> Iterator[Truth]:
    """Yield the truth of one swing per rig; rigs of the same kind run side by side on all cores.

    Raises `InputError` when the rigs differ in more than numbers, or a simulation becomes unstable.
    """
    for value, name in ((duration, "duration"), (rate, "rate"), (step, "step")):
        positive(value, name)
    told = [rig.pivot_moves or (rig.play is not None and rig.loose is None) for rig in rigs]
    if any(told) or any(mount.slides for rig in rigs for mount in rig.mounts):
        raise InputError(
            "swing: expected joints that gravity and torques move, got a pivot, a play or a mount that is told where"
        )
    if len(rigs) != len(starts):
        raise InputError(f"swing_many: expected one start per rig, got {len(rigs)} rigs and {len(starts)} starts")
    split = int(np.ceil(1.0 / (rate * step) - 1e-9))
    samples = round(duration * rate)
    if any(map(needs_ball, rigs)):
        yield from _one_by_one(rigs, starts, samples, split, rate, torque)
        return
    buffer = None  # fresh memory for every block would cost a fifth of the time
    for first in range(0, len(rigs), BLOCK):
        block = range(first, min(first + BLOCK, len(rigs)))
        models = [_compile(rigs[i], 1.0 / (rate * split)) for i in block]
        buffer = _rollout(models, rigs[first].tree, [starts[i] for i in block], samples, split, torque, threads, buffer)
        for i, model, sensordata in zip(block, models, buffer, strict=False):
            yield read_truth(rigs[i], model, np.arange(samples) / rate, sensordata[::split].copy())


def _one_by_one(
    rigs: Sequence[Rig], starts: Sequence[Start], samples: int, split: int, rate: float, torque: Torque | None
) -> Iterator[Truth]:
    """Yield the truth of one swing per rig, with the torques for which MuJoCo has no term (`sim.ball`)."""
    for rig, start in zip(rigs, starts, strict=True):
        model = _compile(rig, 1.0 / (rate * split))
        state, control = (
            initial_state(model, rig.tree, start),
            _control(model, rig.tree, torque, (samples - 1) * split + 1),
        )
        if needs_ball(rig):
            data = swing_ball(rig, model, state, samples, split, control)
        else:
            data = _rollout([model], rig.tree, [start], samples, split, torque, 1, None)[0, ::split]
        if not np.isfinite(data).all():
            raise InputError("swing: expected a simulation that stays finite, got one that does not")
        yield read_truth(rig, model, np.arange(samples) / rate, data)


def _control(model: Any, tree: Tree, torque: Torque | None, steps: int) -> Array | None:
    """Return the applied torques (steps, nv) N m; None where there is none."""
    if torque is None:
        return None
    control = np.zeros((steps, model.nv))
    control[:, _driven_dofs(model, tree)] = torque(np.arange(steps) * model.opt.timestep).reshape(steps, -1)
    return control


def _compile(rig: Rig, step: float) -> Any:
    return compile_model(rig, step, integrator="implicitfast" if rig.sprung else "RK4")


def _rollout(
    models: list[Any],
    tree: Tree,
    starts: list[Start],
    samples: int,
    split: int,
    torque: Torque | None,
    threads: int,
    buffer: Array | None,
) -> Array:
    """Return the sensor data (rigs, steps, nsensordata) of rigs that share their structure, in `buffer` if it fits."""
    model = models[0]
    if any((m.nq, m.nv, m.nsensordata) != (model.nq, model.nv, model.nsensordata) for m in models):
        raise InputError("swing_many: expected rigs that differ in numbers only, got different joints or sensors")
    steps = (samples - 1) * split + 1
    batch = mujoco_batch.Batch(model, nsim=len(models), nthread=threads)
    batch.set_models(models)
    for i, start in enumerate(starts):
        batch.bind("qpos")[i], batch.bind("qvel")[i] = initial_state(models[i], tree, start)
    control = _control(model, tree, torque, steps)
    spec = int(mujoco.mjtState.mjSTATE_QFRC_APPLIED)
    shape = (len(models), steps, model.nsensordata)
    out = {"sensordata": buffer if buffer is not None and buffer.shape == shape else np.empty(shape)}
    try:
        batch.rollout(steps, control=control, control_spec=spec, record=("sensordata",), out=out)
    except mujoco_batch.SimulationError as error:
        raise InputError(f"swing: expected a simulation that stays finite, got: {error}") from error
    check_stable(batch, "swing")
    return out["sensordata"]


def initial_state(model: Any, tree: Tree, start: Start) -> tuple[Array, Array]:
    """Return qpos (nq,) and qvel (nv,) of a start."""
    qpos, qvel = model.qpos0.copy(), np.zeros(model.nv)
    for i in range(model.njnt):
        joint = model.joint(i)
        p, v = int(joint.qposadr[0]), int(joint.dofadr[0])
        if tree.hinge is not None and joint.name == tree.hinge.name:
            qpos[p], qvel[v] = start.angle, start.angle_rate
        elif tree.base is not None and joint.name == tree.base.name:
            if tree.floats:
                qpos[p : p + 3], qvel[v : v + 3] = start.position, start.velocity
                p, v = p + 3, v + 3
            qpos[p : p + 4], qvel[v : v + 3] = start.quaternion, start.rate
    return qpos, qvel


def _driven_dofs(model: Any, tree: Tree) -> list[int]:
    names = {model.joint(i).name: int(model.jnt_dofadr[i]) for i in range(model.njnt)}
    if tree.joint is None or tree.joint.name not in names:
        raise InputError("torque: expected a rig with a hinge or a ball joint that can move, got none")
    first = names[tree.joint.name]
    return list(range(first, first + (1 if tree.hinge is not None else 3)))
