"""The diagnosis of a recording that makes no sense: said at once, without a fit."""

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np

from imubench.diagnosis.config.samples import QUIET_MOMENTS, SCREENING
from imubench.diagnosis.evidence import Evidence, Level, Played, Pose, Trace
from imubench.diagnosis.problem.bspline import SUPPORT
from imubench.diagnosis.residual_checks.fit_summary import CHANNELS_WITH_UNIT, noise_of
from imubench.diagnosis.result import (
    UNKNOWN,
    Diagnosis,
    Finding,
    FitQuality,
    Interval,
    Nonsense,
    Unseen,
    Verdict,
    Where,
)
from imubench.diagnosis.samples.quiet_moments import quiet_level
from imubench.diagnosis.search.confidence import MOST_SURE
from imubench.recording import Recording


def diagnosed_without_fit(recording: Recording, wrong: Sequence[Nonsense], clock: float) -> tuple[Diagnosis, Evidence]:
    """Return the diagnosis of a recording that makes no sense, begun at `clock` (`perf_counter`), and its readings.

    `unobservable` where samples are missing, else `unexplained` with an unknown where something is wrong. Nothing moves
    in its model: the residuals are what the sensors read about their mean.
    """
    found = tuple(_finding(n, recording) for n in wrong if not n.missing)
    unseen = tuple(Unseen(f"anything: {n.what}", n.advice) for n in wrong if n.missing)
    verdict: Verdict = "unexplained" if found else "unobservable"
    evidence = readings(recording, wrong)
    power = [float(np.mean(t.whitened**2)) for t in evidence.traces]
    misfit = float(np.mean(power)) if power else 0.0
    where = tuple(f.where for f in found if f.where is not None)
    quality = FitQuality((misfit, misfit))
    seconds = perf_counter() - clock
    made = Diagnosis(
        recording.name, recording.rig, verdict, (misfit, misfit), where, found, (), quality, "", seconds, unseen
    )
    return with_nonsense(replace(made, noise=noise_of(evidence.levels, recording)), wrong), evidence


def with_nonsense(d: Diagnosis, wrong: Sequence[Nonsense]) -> Diagnosis:
    """Return a diagnosis that says what is wrong with its recording."""
    return replace(d, nonsense=(*d.nonsense, *wrong))


def _finding(n: Nonsense, recording: Recording) -> Finding:
    nothing = Interval(0.0, (0.0, 0.0))
    place = None
    if n.channels:
        time = recording.imu(n.at).time
        share = dict.fromkeys(n.channels, 1 / len(n.channels))
        place = Where(n.at, share, (), ((float(time[0]), float(time[-1])),), "nothing clear", 1.0)
    return Finding(UNKNOWN, n.at, MOST_SURE, {}, nothing, where=place)


def readings(recording: Recording, wrong: Sequence[Nonsense]) -> Evidence:
    """Return what every sensor reads about its mean, on a rig that stands still with its mounts as declared."""
    enough = [i for i in recording.imus if i.time.size >= SCREENING.least_samples] or list(recording.imus)
    groups = [
        (f"{imu.name}.{part}", imu.time, getattr(imu, part), getattr(imu, f"{part}_noise_std"))
        for imu in enough
        for part in ("gyro", "accel")
    ]
    groups += [("encoder.angle", e.time, e.angle[:, None], e.angle_noise_std) for e in recording.encoders]
    traces, levels = [], []
    for name, time, values, told in groups:
        at, part = name.split(".")
        channels, unit = CHANNELS_WITH_UNIT[part]
        noise = max(told or quiet_level(time, values), QUIET_MOMENTS.finest)
        about = values - values.mean(axis=0)
        traces.append(Trace(at, part, channels, unit, time, about, noise))
        levels.append(Level(name, unit, told, noise, float(np.sqrt(np.mean(about**2)))))
    mounts = {imu.name: Pose(imu.mount_position, imu.mount_quaternion) for imu in recording.imus}
    notes = (
        "Nothing was fitted: before that every sensor is held against itself and against the others, and these do not "
        "go together.",
        *(f"{n.what}: {_numbers(n)}." for n in wrong if n.evidence),
    )
    return Evidence(recording, tuple(traces), still(recording), mounts, tuple(levels), notes=notes)


def _numbers(n: Nonsense) -> str:
    return ", ".join(f"{name.replace('_', ' ')} {value:.3g}" for name, value in n.evidence.items())


def still(recording: Recording) -> Played:
    """Return a motion in which nothing moves."""
    clocks = [i.time for i in recording.imus] + [e.time for e in recording.encoders] + [p.time for p in recording.poses]
    time = np.linspace(min(t[0] for t in clocks), max(t[-1] for t in clocks), SUPPORT)  # as few as a spline takes
    turn = recording.base_quaternion if recording.clamped else [1.0, 0, 0, 0]
    angle = np.zeros(SUPPORT) if recording.tree.hinge is not None else None
    return Played(time, np.tile(turn, (SUPPORT, 1)), np.zeros((SUPPORT, 3)), angle)


__all__ = ["diagnosed_without_fit", "with_nonsense"]
