"""Prescribed motion: segments (and sensors on a path) do what they are told; sprung sensors, loose limbs follow.

Segments are driven (see `compile.DRIVEN_ARMATURE`), so MuJoCo solves inverse dynamics for them. The mounts are
integrated forward (`sprung`). What a sensor reads is evaluated at the samples alone, every driven joint at its true
position, rate and acceleration: by MuJoCo's sensors, or of sprung mounts by the laws that they follow (`felt`).
"""

from typing import Any, Literal

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError, unknown
from imubench.recording import positive
from imubench.sim.compile import compile_model
from imubench.sim.driven import evaluate, joint_state
from imubench.sim.felt import read_mounts
from imubench.sim.kinematics import segments_of
from imubench.sim.motion import Motion, Trajectory
from imubench.sim.on_warp import evaluate as evaluate_on_warp
from imubench.sim.readout import read_truth, truth_of
from imubench.sim.rigs import Rig
from imubench.sim.sprung import sprung_motion
from imubench.truth import Truth

ENGINES = ("mujoco", "warp")


def play(
    rig: Rig,
    motion: Motion,
    duration: float,
    rate: float = 1000.0,
    step: float | None = None,
    labels: tuple[tuple[str, float, float], ...] = (),
    threads: int = 0,
    engine: Literal["mujoco", "warp"] = "mujoco",
) -> Truth:
    """Return the truth of a prescribed motion, `rate` samples a second for `duration` s.

    `step` is the longest integration step of sprung mounts in s; None takes an eighth of the period of their fastest
    mode, less where that is hardly damped, and 5 ms at most. `threads` 0 uses every core; no result depends on it.
    `engine` "warp" has the samples evaluated by MuJoCo Warp (`on_warp`), in single precision, on a GPU where one is.
    Raises `InputError` for a motion that is defined for less than `duration`, and
    its kind `UnheldSensorError` where springs do not hold a sensor.
    """
    if engine not in ENGINES:
        raise unknown("engine", engine, ENGINES)
    if engine == "warp" and rig.loose is not None:
        raise InputError(
            "engine 'warp': expected joints that are driven, got a loose limb; its stops are MuJoCo's alone"
        )
    positive(duration, "duration")
    positive(rate, "rate")
    time = np.arange(round(duration * rate)) / rate
    _check_lasts(motion, duration, time)
    model = compile_model(rig, driven="joints" if rig.follows else "all")
    mounts, trajectory = _followed(rig, model, motion, time, rate, step)
    plain = rig.play is None and not rig.wanders and not any(mount.slides for mount in rig.mounts)
    if mounts is not None and engine == "mujoco" and plain:
        segments = segments_of(rig, trajectory)
        return truth_of(rig, time, segments, read_mounts(rig, segments, *mounts), labels, trajectory)
    state = joint_state(rig, model, trajectory, mounts)
    data = evaluate_on_warp(model, *state) if engine == "warp" else evaluate(model, *state, threads=threads)
    return read_truth(rig, model, time, data, labels, trajectory)


def _check_lasts(motion: Motion, duration: float, time: Array) -> None:
    """Raise `InputError` for a motion that ends before the last sample, before anything is computed."""
    try:
        motion(time[-1:])
    except InputError as error:
        raise InputError(f"play of {duration:g} s: {error}") from None


def _followed(
    rig: Rig, model: Any, motion: Motion, time: Array, rate: float, step: float | None
) -> tuple[tuple[Array, Array] | None, Trajectory]:
    """Return the state of what follows by forces, if anything does, and the trajectory, at `time`."""
    if not rig.follows:
        return None, motion(time)
    positions, velocities, trajectory = sprung_motion(rig, model, motion, time.size, rate, step)
    return (positions, velocities), trajectory
