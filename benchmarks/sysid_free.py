"""A swinging hinge in MuJoCo's own system identification, with every parameter free that it can express."""

from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from typing import Any

import mujoco
import numpy as np

from imubench import rotations
from imubench.correction.found_rig import rig_of
from imubench.diagnosis.evidence import Pose
from imubench.recording import Recording
from imubench.sim.compile import specify

SIGMAS = 5.0
MOST_STEPS = 60  # of its optimiser
READINGS = {"gyro": "gyro", "accelerometer": "accel"}  # MuJoCo's sensor -> ours
Put = Callable[[Any, np.ndarray], None]  # a value into an MjSpec


@dataclass(frozen=True)
class Free:
    """One parameter that is set free: whose effect it is, where it begins, its bounds, and where it goes."""

    name: str
    effect: str
    declared: np.ndarray
    low: np.ndarray
    high: np.ndarray
    put: Put | None = None  # None: into the signals


@dataclass(frozen=True)
class Identified:
    """What came out: effects five standard deviations from what is declared, the most significant first."""

    said: tuple[str, ...]
    misfit: float  # residual over the noise, RMS
    parameters: int


def free_parameters(spec: Any) -> Iterator[Free]:
    """Yield what may be free of a hinge with two IMUs."""
    for imu in ("imu1", "imu2"):
        for reading, width in (("gyro", 0.2), ("accel", 2.0)):
            yield _around(f"{imu}_{reading}_bias", f"{reading}_bias@{imu}", np.zeros(3), width)
            yield _around(f"{imu}_{reading}_gain", f"{reading}_scale@{imu}", np.ones(3), 0.2)
        yield _around(f"{imu}_delay", f"time_offset@{imu}", np.zeros(1), 0.03)
        yield _around(
            f"{imu}_turn", f"mount_pose@{imu}", np.zeros(3), 0.15, _turned(imu, np.array(spec.body(imu).quat))
        )
        yield _around(f"{imu}_place", f"mount_pose@{imu}", np.array(spec.body(imu).pos), 0.03, _set(imu))
    inertia = np.array(spec.body("segment2").inertia)
    torques: dict[str, tuple[str, float, Put]] = {
        "damping": ("viscous_friction", 1.0, lambda s, x: _into(s.joint("hinge").damping, 0, x)),
        "drag": ("air_drag", 1.0, lambda s, x: _into(s.joint("hinge").damping, 1, x)),
        "friction": ("dry_friction", 1.0, lambda s, x: setattr(s.joint("hinge"), "frictionloss", float(x[0]))),
        "stiffness": ("joint_spring", 5.0, lambda s, x: _into(s.joint("hinge").stiffness, 0, x)),
    }
    for name, (effect, most, put) in torques.items():
        yield Free(name, f"{effect}@joint", np.full(1, 1e-3), np.zeros(1), np.full(1, most), put)
    yield _around(
        "inertia", "inertia@body", np.ones(1), 0.4, lambda s, x: setattr(s.body("segment2"), "inertia", inertia * x[0])
    )
    down = -np.array(spec.option.gravity)[2:]
    yield _around("gravity", "gravity@world", down, 0.5, lambda s, x: setattr(s.option, "gravity", [0.0, 0.0, -x[0]]))


def identify(recording: Recording, angle: float, rate: float) -> Identified:
    """Return what `mujoco.sysid` makes of the first free swing, begun at the true angle (rad) and rate (rad/s).

    It gets all IMUs on one time grid and residuals over the declared noise.
    """
    from mujoco import sysid

    mounts = {i.name: Pose(i.mount_position, i.mount_quaternion) for i in recording.imus}
    spec = specify(rig_of(recording, mounts), watch_segments=False)
    for sensor in [s for s in spec.sensors if s.name.split("_")[1] not in READINGS]:
        spec.delete(sensor)
    spec.add_actuator(name="none", target="hinge", trntype=mujoco.mjtTrn.mjTRN_JOINT, gear=[0.0] * 6)
    model = spec.compile()
    free = list(free_parameters(spec))
    times, measured, noise = _readings(recording, [model.sensor(k).name for k in range(model.nsensor)])
    steps = np.arange(0.0, times[-1], model.opt.timestep)
    begin = sysid.create_initial_state(model, np.array([angle]), np.array([rate]), np.zeros(0))
    case = sysid.ModelSequences(
        "hinge",
        spec,
        "swing",
        begin,
        sysid.TimeSeries(steps, np.zeros((len(steps), 1))),
        sysid.TimeSeries.from_names(times, measured, model),
    )
    unknown, signals = sysid.ParameterDict(), sysid.SignalTransform(normalize=False)
    for one in free:
        unknown.add(sysid.Parameter(one.name, one.declared, one.low, one.high, modifier=_modifier(one.put)))
    for imu in recording.imus:
        signals.delay(f"{imu.name}_*", unknown[f"{imu.name}_delay"])
        for theirs, ours in READINGS.items():
            signals.gain(f"{imu.name}_{theirs}", unknown[f"{imu.name}_{ours}_gain"], target="predicted")
            signals.bias(f"{imu.name}_{theirs}", unknown[f"{imu.name}_{ours}_bias"], target="predicted")
    signals.set_sensor_weights(1 / noise)

    def apply(*args: Any, **options: Any) -> tuple[np.ndarray, Any, Any]:
        # Its check that both sides have the same sensors compares arrays, which fails on sensors of three columns
        # unless the mapping is one object.
        left, foretold, read = signals.apply(*args, **options)
        return left, sysid.TimeSeries(foretold.times, foretold.data, read.signal_mapping), read

    residual = sysid.build_residual_fn(models_sequences=[case], modify_residual=apply)
    with redirect_stdout(StringIO()):
        found, result = sysid.optimize(
            unknown, residual, optimizer="mujoco", verbose=False, max_iters=MOST_STEPS, x_scale="jac"
        )
    left = residual(found.as_vector(), found)[0]
    _, half_widths = sysid.calculate_intervals(left, np.asarray(result.jac))
    return Identified(_significant(free, found.as_vector(), half_widths / 1.96), _rms(left), found.size)


def _significant(free: list[Free], values: np.ndarray, std: np.ndarray) -> tuple[str, ...]:
    declared = np.concatenate([one.declared for one in free])
    effects = [one.effect for one in free for _ in one.declared]
    off = np.abs(values - declared) / np.where(np.isfinite(std) & (std > 0), std, np.inf)
    most: dict[str, float] = {}
    for effect, sigmas in zip(effects, off.tolist(), strict=True):
        most[effect] = max(most.get(effect, 0.0), sigmas)
    return tuple(sorted((e for e, sigmas in most.items() if sigmas > SIGMAS), key=lambda e: -most[e]))


def _readings(recording: Recording, names: list[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times (n,) from the swing's start in s, readings (n, columns) and the noise (columns,) of each."""
    start, end = recording.free_swings[0]
    times = recording.imus[0].time
    times = times[(times >= start) & (times <= end)]
    columns, noise = [], []
    for name in names:
        imu, reading = recording.imu(name.split("_")[0]), READINGS[name.split("_")[1]]
        columns += [np.interp(times, imu.time, column) for column in getattr(imu, reading).T]
        noise += [float(getattr(imu, f"{reading}_noise_std"))] * 3
    return times - start, np.column_stack(columns), np.array(noise)


def _rms(left: list[np.ndarray]) -> float:
    return float(np.sqrt(np.mean(np.concatenate([r.ravel() for r in left]) ** 2)))


def _around(name: str, effect: str, declared: np.ndarray, width: float, put: Put | None = None) -> Free:
    return Free(name, effect, declared, declared - width, declared + width, put)


def _modifier(put: Put | None) -> Callable[[Any, Any], None] | None:
    return None if put is None else lambda spec, parameter: put(spec, np.asarray(parameter.value))


def _turned(imu: str, declared: np.ndarray) -> Put:
    return lambda s, x: setattr(s.body(imu), "quat", rotations.multiply(declared, rotations.exp(x)))


def _set(imu: str) -> Put:
    return lambda s, x: setattr(s.body(imu), "pos", x)


def _into(values: np.ndarray, k: int, x: np.ndarray) -> None:
    values[k] = x[0]
