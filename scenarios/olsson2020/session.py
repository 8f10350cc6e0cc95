"""All 14 motions recorded one after the other with the same two IMUs, as the paper's data were.

One call of the IMU model spans the whole session: constant errors are drawn once, slow ones run on from
motion to motion, and a motion that appears twice in a sequence brings the same samples twice.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError, unknown
from imubench.recording import Imu, Recording, positive
from imubench.scenarios.olsson2020.motions import DURATION, MARGIN, MOTIONS, OlssonMotion, paper_rig
from imubench.scenarios.scenario import declared_mounts
from imubench.sim.imu_model import Declared, observe
from imubench.sim.imu_profile import ImuProfile
from imubench.sim.play import play
from imubench.sim.profiles import profile
from imubench.sim.rigs import Rig
from imubench.truth import Truth

OVERSAMPLING = 10  # of the truth, for IMUs with a filter or a clock of their own
SNAP = 1e-6  # s, stamps this close below a limit lie on it

Alter = Callable[[OlssonMotion, Truth, np.random.Generator], Truth]
"""Changes what a motion's sensors feel, before the IMU model: a hook for what a rig cannot express."""


@dataclass(frozen=True)
class Session:
    """The recording of all motions, transitions included, and what really happened."""

    seed: int
    rig: Rig
    truth: Truth  # dense; its labels say where each motion lies
    recording: Recording
    gyro_bias: dict[str, Array]  # (3,) rad/s a sensor, the mean of motion 1
    spans: dict[int, tuple[float, float]]  # s, of each motion proper, by number

    def span(self, number: int) -> tuple[float, float]:
        """Return where a motion lies, in s; `InputError` names the known ones."""
        if number not in self.spans:
            raise unknown("motion", number, self.spans)
        return self.spans[number]

    @property
    def axes(self) -> Array:
        """The true hinge axis in both sensors' axes (2, 3); on soft mounts its mean direction."""
        axes = np.array([s.joint_axis.mean(axis=0) for s in self.truth.sensors if s.joint_axis is not None])
        return axes / np.linalg.norm(axes, axis=-1, keepdims=True)


def record(
    seed: int,
    rig: Rig | None = None,
    imus: ImuProfile | Mapping[str, ImuProfile] | None = None,
    remove_gyro_bias: bool = True,
    durations: Mapping[int, float] | None = None,
    alter: Alter | None = None,
) -> Session:
    """Play and record the 14 motions; the same seed gives the same numbers.

    `rig` defaults to the paper's, `imus` to its MTw at 50 Hz; a mapping gives each sensor its own. The gyroscope
    bias found in motion 1 is subtracted everywhere, as in the paper, unless `remove_gyro_bias` is false. Stamps of
    an IMU with a clock of its own may run off by up to MARGIN; beyond that, motions reach into each other.
    `durations` in s by number replaces the 50 s. Changing the IMUs leaves the motions as they are, and the reverse.
    Raises `InputError` for a rig that is no hinge with two IMUs, an unknown motion or too short a duration.
    """
    rig = paper_rig() if rig is None else rig
    imus = profile("xsens_mtw") if imus is None else imus
    if rig.family != "hinge" or len(rig.mounts) != 2:
        raise InputError(f"rig: expected a hinge with two IMUs, got {rig.family} with {len(rig.mounts)}")
    truth_rate, lengths = _truth_rate(imus), _durations(durations or {})
    playing, observing, altering, declaring = np.random.default_rng(seed).spawn(4)
    truths = []
    for (number, motion), draw, other in zip(MOTIONS.items(), playing.spawn(14), altering.spawn(14), strict=True):
        truth = play(rig, motion.motion(draw, lengths[number]), lengths[number] + 2 * MARGIN, truth_rate)
        truths.append(truth if alter is None else alter(motion, truth, other))
    truth, spans = _joined(truths, lengths)
    declaration = Declared(mounts=declared_mounts(rig, declaring))
    recording = observe(truth, imus, observing, f"olsson2020-{seed}", declaration)
    biases = {imu.name: rows_between(imu, *spans[1]).gyro.mean(axis=0) for imu in recording.imus}
    if remove_gyro_bias:
        corrected = tuple(replace(imu, gyro=imu.gyro - biases[imu.name]) for imu in recording.imus)
        recording = replace(recording, imus=corrected)
    return Session(seed, rig, truth, recording, biases, spans)


def rows_between(imu: Imu, start: float, end: float) -> Imu:
    """Return the samples of an IMU whose stamps lie in [start, end) s."""
    first, last = np.searchsorted(imu.time, [start - SNAP, end - SNAP])
    return replace(imu, time=imu.time[first:last], gyro=imu.gyro[first:last], accel=imu.accel[first:last])


def _durations(changes: Mapping[int, float]) -> dict[int, float]:
    for number, duration in changes.items():
        if number not in MOTIONS:
            raise unknown("motion", number, MOTIONS)
        positive(duration, f"duration of motion {number}")
    return {number: float(changes.get(number, DURATION)) for number in MOTIONS}


def _truth_rate(imus: ImuProfile | Mapping[str, ImuProfile]) -> float:
    """Return the rate in Hz at which the truth is needed: that of the IMUs if they sample it as it is."""
    profiles = [imus] if isinstance(imus, ImuProfile) else list(imus.values())
    fastest = max(p.rate for p in profiles)
    own = any(
        p.rate != fastest or p.jitter_std or p.clock_offset or p.clock_skew or p.gyro.bandwidth or p.accel.bandwidth
        for p in profiles
    )
    return fastest * (OVERSAMPLING if own else 1)


def _joined(truths: list[Truth], lengths: Mapping[int, float]) -> tuple[Truth, dict[int, tuple[float, float]]]:
    """Return one truth after the other on one clock, and where the motions proper lie on it."""
    counts = np.array([t.time.size for t in truths])
    step = truths[0].time[1] - truths[0].time[0]
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]]) * step
    spans = {n: (start + MARGIN, start + MARGIN + lengths[n]) for n, start in zip(MOTIONS, starts, strict=True)}
    angles, rates = ([getattr(t, key) for t in truths] for key in ("joint_angle", "joint_rate"))
    joined = replace(
        truths[0],
        time=np.arange(counts.sum()) * step,
        segments=tuple(_stacked(parts) for parts in zip(*(t.segments for t in truths), strict=True)),
        sensors=tuple(_stacked(parts) for parts in zip(*(t.sensors for t in truths), strict=True)),
        joint_angle=np.concatenate(angles),
        joint_rate=np.concatenate(rates),
        labels=tuple((f"motion {n}: {MOTIONS[n].name}", *span) for n, span in spans.items()),
    )
    return joined, spans


def _stacked(parts: tuple[Any, ...]) -> Any:
    """Return parts of one kind with every array field concatenated."""
    arrays = [f.name for f in fields(parts[0]) if isinstance(getattr(parts[0], f.name), np.ndarray)]
    return replace(parts[0], **{name: np.concatenate([getattr(p, name) for p in parts]) for name in arrays})
