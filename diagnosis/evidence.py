"""What the report draws and diagnosis.json does not hold: residuals over time, predictions, the recovered motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from imubench.arrays import Array, frozen, frozen_quaternion, frozen_time
from imubench.diagnosis.result import Finding
from imubench.diagnosis.rules import Decision
from imubench.effects.effect import Setting
from imubench.errors import InputError
from imubench.recording import Recording, positive
from imubench.sim.swing import Start


@dataclass(frozen=True)
class Trace:
    """One sensor triple's residuals, measured minus model, in `unit`."""

    at: str  # imu1, imu2, encoder, pose1
    part: str  # gyro, accel, angle, position, rotation
    channels: tuple[str, ...]  # without the sensor: gyr_x, gyr_y, gyr_z
    unit: str
    time: Array  # (n,) s, the sensor's stamps
    before: Array  # (n, k) of the nominal model
    noise: float  # std of a residual where there is only noise
    after: Array | None = None  # (n, k) with the findings in the model; None where there are none

    def __post_init__(self) -> None:
        put, name = object.__setattr__, self.name
        put(self, "time", frozen_time(self.time, f"{name}.time"))
        shape = (self.time.size, len(self.channels))
        put(self, "before", frozen(self.before, shape, f"{name}.before"))
        if self.after is not None:
            put(self, "after", frozen(self.after, shape, f"{name}.after"))
        positive(self.noise, f"{name}.noise")

    @property
    def name(self) -> str:
        """As a group of the fit is written: imu1.gyro."""
        return f"{self.at}.{self.part}"

    @property
    def whitened(self) -> Array:
        """The nominal model's residuals (n, k) over the noise."""
        return self.before / self.noise

    @property
    def whitened_after(self) -> Array | None:
        """The explained model's residuals (n, k) over the noise."""
        return None if self.after is None else self.after / self.noise


@dataclass(frozen=True)
class Comparison:
    """One channel: measured, and simulated by MuJoCo without and with a finding, or all of them."""

    channel: str  # imu2.acc_x, encoder.hinge
    unit: str
    time: Array  # (n,) s, the sensor's stamps
    measured: Array  # (n,)
    before: Array  # (n,) of the model without the finding
    after: Array  # (n,) and with it
    noise: float  # std of the channel's noise
    held_out: tuple[tuple[float, float], ...] = ()  # windows in s whose numbers were learned on other samples

    def __post_init__(self) -> None:
        object.__setattr__(self, "held_out", tuple((float(a), float(b)) for a, b in self.held_out))
        object.__setattr__(self, "time", frozen_time(self.time, f"{self.channel}.time"))
        for key in ("measured", "before", "after"):
            object.__setattr__(self, key, frozen(getattr(self, key), (self.time.size,), f"{self.channel}.{key}"))
        positive(self.noise, f"{self.channel}.noise")


@dataclass(frozen=True)
class FittedEffect:
    """An effect at a place as it was fitted: numbers that no report names are with it."""

    effect: str  # "unknown" of a term without a name
    at: str
    variant: str = ""
    settings: Mapping[str, Setting] = field(default_factory=dict)
    values: Mapping[str, Array] = field(default_factory=dict)  # parameter -> its shape, in its unit
    time: Array = field(default_factory=lambda: np.zeros(0))  # (n,) s since the recording's start, of the signals
    signals: Mapping[str, Array] = field(default_factory=dict)  # states, or what is unknown by part: (n, m)


@dataclass(frozen=True)
class Played:
    """A recovered motion. Its heading, and its place where no pose is measured, are arbitrary."""

    time: Array  # (n,) s
    quaternion1: Array  # (n, 4) segment 1 -> world
    position: Array  # (n, 3) m, segment 1's origin, world
    hinge_angle: Array | None = None  # (n,) rad
    force: Array | None = None  # (n, 3) m/s^2, segment 1's specific force at its origin; None: the position says it
    fitted: tuple[FittedEffect, ...] = ()  # the effects that it was recovered with, and what has no name
    play: Array | None = None  # (2, n) rad, how a limb turned about the axis of its play and beside it, where told

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", frozen_time(self.time, "motion.time"))
        n = self.time.size
        for key, shape in (
            ("quaternion1", (n, 4)), ("position", (n, 3)), ("hinge_angle", (n,)), ("force", (n, 3)), ("play", (2, n)),
        ):  # fmt: skip
            if getattr(self, key) is not None:
                object.__setattr__(self, key, frozen(getattr(self, key), shape, f"motion.{key}"))


@dataclass(frozen=True)
class Posed:
    """A rig as MuJoCo plays it, its sensors where springs, slips and play have them."""

    time: Array  # (n,) s, the recording's clock
    segments: Mapping[str, tuple[Array, Array]]  # position (n, 3) m and quaternion (n, 4), segment -> world
    sensors: Mapping[str, tuple[Array, Array]]  # position (n, 3) m and quaternion (n, 4), sensor -> world

    def __post_init__(self) -> None:
        n = self.time.size
        object.__setattr__(self, "time", frozen_time(self.time, "posed.time"))
        for key in ("segments", "sensors"):
            held = {
                name: (frozen(x, (n, 3), f"posed.{name}"), frozen(q, (n, 4), f"posed.{name}"))
                for name, (x, q) in getattr(self, key).items()
            }
            object.__setattr__(self, key, held)


@dataclass(frozen=True)
class Swing:
    """A stretch of a free swing and the state at its start."""

    start: float  # s, the recording's clock
    end: float  # s
    state: Start

    def __post_init__(self) -> None:
        if not self.end > self.start:
            raise InputError(f"swing: expected an end after its start, got {self.start:g} to {self.end:g} s")


@dataclass(frozen=True)
class Pose:
    """A fitted mount: the sensor in its segment."""

    position: Array  # (3,) m
    quaternion: Array  # (4,) sensor -> segment

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", frozen(self.position, (3,), "mount.position"))
        object.__setattr__(self, "quaternion", frozen_quaternion(self.quaternion, "mount.quaternion"))


@dataclass(frozen=True)
class Level:
    """How large one group's noise is."""

    group: str  # imu1.gyro
    unit: str
    declared: float | None
    used: float  # what counts as noise in this diagnosis
    left: float  # what the nominal model leaves, freed from what the fit absorbs


@dataclass(frozen=True)
class Estimated:
    """What an estimator makes of the recording as it came, and without what was found in it."""

    estimator: str
    quantity: str  # joint_axis, joint_vector
    unit: str  # deg, mm
    imus: tuple[str, ...]  # (m,)
    moved: Array  # (m,) by what all findings together move it
    each: tuple[Array | None, ...]  # for every finding, in their order: by what it alone moves it; None: it stays in
    off: tuple[Array, Array] | None = None  # (m,) from an independent reference: as it came, and without
    status: tuple[str, str] = ("converged", "converged")  # as it came, and without


@dataclass(frozen=True)
class Evidence:
    """Everything that is shown beside a diagnosis."""

    recording: Recording
    traces: tuple[Trace, ...]
    motion: Played  # of the best model, as it is estimated
    mounts: Mapping[str, Pose]  # of the best model, by IMU
    levels: tuple[Level, ...]
    motion_before: Played | None = None  # of the nominal model, where it is another
    prescribed: Played | None = None  # that a replay prescribes, where it is smoother than the one that is estimated
    heldout_s: tuple[tuple[float, float], ...] = ()  # windows that the fit has not seen
    comparisons: tuple[tuple[Comparison, ...], ...] = ()  # for every finding, in their order: without and with it
    simulated: tuple[Comparison, ...] = ()  # every channel: the declared model, and the model with all findings
    posed: tuple[Posed, ...] = ()  # as simulated: the declared model and the model with all findings, or only that one
    rolled_out: tuple[Swing, ...] = ()  # stretches of free swings that a replay rolls out, the states at their starts
    taught: tuple[Finding, ...] = ()  # named effects with the numbers that roll-outs show: those of `model/`
    estimates: tuple[Estimated, ...] = ()  # of the project's estimators, where what was found can be taken out
    notes: tuple[str, ...] = field(default=())  # how it was done, a sentence each
    fired: Mapping[str, int] = field(
        default_factory=dict
    )  # rule (diagnosis/rules.py) -> how often it changed something
    decisions: tuple[Decision, ...] = ()  # of the search, in their order

    @property
    def replayed(self) -> Played:
        """The motion that a replay prescribes."""
        return self.motion if self.prescribed is None else self.prescribed

    @property
    def span(self) -> tuple[float, float]:
        """The first and the last time in s."""
        return min(float(t.time[0]) for t in self.traces), max(float(t.time[-1]) for t in self.traces)

    def trace(self, at: str, channel: str) -> tuple[Trace, int]:
        """Return the trace that holds a channel, and its column; `InputError` where there is none."""
        for trace in self.traces:
            if trace.at == at and channel in trace.channels:
                return trace, trace.channels.index(channel)
        raise InputError(f"unknown channel '{at}.{channel}'")


def of_sensor(traces: Sequence[Trace]) -> dict[str, list[Trace]]:
    """Return the traces by sensor, in their order."""
    out: dict[str, list[Trace]] = {}
    for trace in traces:
        out.setdefault(trace.at, []).append(trace)
    return out
