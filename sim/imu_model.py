"""An IMU model turns Truth into a Recording.

For the gyroscope (x = angular rate) and the accelerometer (x = specific force f, A = 0), in this order::

    z = x + M x + s.x + A f           on the dense truth, sensor axes
    z = low-pass(z)                   first order, causal, on the dense truth
    y = z(t_k + jitter)               cubic interpolation at the IMU's own instants
    y = y + b + b_walk + b_instab + n at its samples; n has passed the same filter
    y = clip(round(y / step) step)    to +- range
    drop-outs                         whole samples, missing or held

docs/imu-profiles.md has the equations of the random terms.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from imubench.arrays import Array, frozen, frozen_quaternion
from imubench.errors import unknown
from imubench.recording import Body, Encoder, Imu, Pose, Recording
from imubench.sim.imu_noise import Draws, additive_errors, linear_errors, spawn_sources
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.sim.imu_sampling import SamplingPlan, dense_step, interpolate, kept_rows, low_pass, sampling_plan
from imubench.truth import SensorTruth, Truth


@dataclass(frozen=True)
class DeclaredMount:
    """Where the owner believes an IMU to be, and how well that is known."""

    position: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m, segment frame
    quaternion: Array = field(default_factory=lambda: np.array([1.0, 0, 0, 0]))  # sensor -> segment
    position_std: float | None = None  # m; None: unknown
    rotation_std: float | None = None  # rad

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", frozen(self.position, (3,), "mount.position"))
        object.__setattr__(self, "quaternion", frozen_quaternion(self.quaternion, "mount.quaternion"))


@dataclass(frozen=True)
class Declared:
    """What the owner of an experiment declares beside the IMUs' samples; it need not be true."""

    mounts: Mapping[str, DeclaredMount] = field(default_factory=dict)  # by sensor name
    motion: Literal["hand", "free"] = "hand"
    gravity: float | None = None  # m/s^2; None: the true one
    base: Literal["free", "fixed"] = "free"
    base_quaternion: Array = field(default_factory=lambda: np.array([1.0, 0, 0, 0]))  # segment 1 -> world
    encoders: tuple[Encoder, ...] = ()
    poses: tuple[Pose, ...] = ()
    free_swings: tuple[tuple[float, float], ...] = ()  # (start, end) s
    body: Body | None = None


def observe(
    truth: Truth,
    profiles: Mapping[str, ImuProfile] | ImuProfile,
    rng: np.random.Generator,
    name: str = "simulated",
    declared: Declared | None = None,
) -> Recording:
    """Return what IMUs with these `profiles` record of `truth`.

    One profile stands for every sensor; a mapping names the sensors that are there. Each sensor and each
    error source has a generator of its own, spawned from `rng`: the same seed gives the same recording, and
    a change of one error, or of one sensor, leaves the draws of the others alone.
    Raises `InputError` for a profile or a mount of an unknown sensor, or a truth that is not evenly spaced.
    """
    declared = Declared() if declared is None else declared
    known = [sensor.name for sensor in truth.sensors]
    by_name = dict.fromkeys(known, profiles) if isinstance(profiles, ImuProfile) else dict(profiles)
    for sensor_name in (*by_name, *declared.mounts):
        if sensor_name not in known:
            raise unknown("sensor", sensor_name, known)
    streams = dict(zip(known, rng.spawn(len(known)), strict=True))
    imus = tuple(
        observe_imu(s, truth.time, by_name[s.name], streams[s.name], mount=declared.mounts.get(s.name))
        for s in truth.sensors
        if s.name in by_name
    )
    return Recording(
        name=name,
        rig=truth.rig,
        imus=imus,
        motion=declared.motion,
        gravity=truth.gravity if declared.gravity is None else declared.gravity,
        base=declared.base,
        base_quaternion=declared.base_quaternion,
        encoders=declared.encoders,
        poses=declared.poses,
        free_swings=declared.free_swings,
        body=declared.body,
    )


def observe_imu(
    sensor: SensorTruth,
    time: Array,
    profile: ImuProfile,
    rng: np.random.Generator,
    name: str | None = None,
    mount: DeclaredMount | None = None,
) -> Imu:
    """Return the samples of one IMU that moves as `sensor` does at `time` (n,) s, with its declared facts.

    Declared are the rate, the ranges and the noise std per sample of the profile, rounding included;
    biases, scale and the other errors are not. `name` defaults to the sensor's.
    """
    mount = DeclaredMount() if mount is None else mount
    draws = spawn_sources(rng)
    plan = sampling_plan(time, profile, draws["jitter"])
    step = dense_step(time)
    coupled = sensor.specific_force @ profile.g_sensitivity.T if profile.g_sensitivity.any() else None
    gyro = _read(sensor.gyro, coupled, profile.gyro, "gyro", draws, plan, step, profile.rate)
    accel = _read(sensor.specific_force, None, profile.accel, "accel", draws, plan, step, profile.rate)
    rows = kept_rows(plan.stamps.size, profile, draws["dropouts"])
    held = profile.dropout_mode == "held"
    return Imu(
        name=sensor.name if name is None else name,
        time=plan.stamps if held else plan.stamps[rows],
        gyro=gyro[rows],
        accel=accel[rows],
        rate=profile.rate,
        gyro_noise_std=profile.gyro.declared_noise_std(profile.rate),
        accel_noise_std=profile.accel.declared_noise_std(profile.rate),
        gyro_range=profile.gyro.range,
        accel_range=profile.accel.range,
        mount_position=mount.position,
        mount_quaternion=mount.quaternion,
        mount_position_std=mount.position_std,
        mount_rotation_std=mount.rotation_std,
    )


def _read(
    true: Array,
    coupled: Array | None,
    channel: ChannelProfile,
    kind: str,
    draws: Draws,
    plan: SamplingPlan,
    step: float,
    rate: float,
) -> Array:
    """Return the readings (m, 3) of one channel; `coupled` (n, 3) is what the other one leaks into it."""
    signal = true
    matrix = linear_errors(channel, kind, draws)
    if matrix.any():
        signal = signal + true @ matrix.T
    if coupled is not None:
        signal = signal + coupled
    if channel.bandwidth is not None:
        signal = low_pass(signal, step, channel.bandwidth)
    reading = interpolate(signal, plan.positions)
    additive = additive_errors(channel, kind, draws, len(reading), rate)
    if additive.any():  # so that a perfect channel returns the truth bit by bit, the sign of a zero included
        reading = reading + additive
    if channel.step:
        reading = np.round(reading / channel.step) * channel.step
    if channel.range is not None:
        reading = np.clip(reading, -channel.range, channel.range)
    return reading
