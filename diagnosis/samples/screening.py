"""What the raw samples of a recording say before any fit: findings, and which samples a fit leaves out."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from imubench.diagnosis.config.samples import NOISE_FLOOR, SCREENING
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.diagnosis.samples import checks as raw
from imubench.diagnosis.samples.check_findings import RawFinding
from imubench.diagnosis.samples.notch import turns_with_hum, with_steady_hum, without_further_hums, without_hum
from imubench.diagnosis.samples.pose_correlation import GaussMarkov, correlated_poses
from imubench.diagnosis.samples.rest_noise import MOST_REST_STD
from imubench.effects import traits_of
from imubench.effects.traits import Fault
from imubench.recording import Imu, Recording


@dataclass(frozen=True)
class SampleChecks:
    """The raw checks of every IMU and encoder together."""

    findings: tuple[Finding, ...]
    masks: dict[str, NDArray[np.bool_]]  # "imu1.gyro" -> samples (n,) that count
    unless_stopped: tuple[Finding, ...] = ()  # knocks that are findings only where no end stop is
    struck: dict[str, NDArray[np.bool_]] = field(default_factory=dict)  # "imu1" -> (n,) the part of masks that is peaks
    notes: tuple[str, ...] = field(default=())
    white: dict[str, float] = field(default_factory=dict)  # "imu1.gyro" -> std of a noise that the samples show alone
    wander: dict[str, GaussMarkov] = field(default_factory=dict)  # "pose1" whose errors last, and how
    rest: dict[str, float] = field(default_factory=dict)  # "imu1.gyro" -> std of the noise of a sensor that has rested

    @property
    def humming(self) -> dict[str, float]:
        """The IMUs that hum, and at how many Hz."""
        tones = ((f, traits_of(f.effect).tone) for f in self.findings)
        return {f.at: float(f.parameters[tone].value) for f, tone in tones if tone}

    def heard(self, recording: Recording) -> Recording:
        """Return the recording with its noise declared as these samples have it, and without what fits no hum's law."""
        imus = []
        for imu in recording.imus:
            none = np.ones(imu.time.size, dtype=bool)
            skip = ~(self.masks.get(f"{imu.name}.gyro", none) & self.masks.get(f"{imu.name}.accel", none))
            hum = self.humming.get(imu.name)
            if hum is not None and turns_with_hum(imu, hum, skip):
                gyro, accel = without_hum(imu, hum, skip)
                imu = without_further_hums(replace(imu, gyro=gyro, accel=accel), skip)
            elif hum is not None:
                imu = replace(imu, accel=with_steady_hum(imu, hum, skip))
            imus.append(imu)
        return with_sample_noise(replace(recording, imus=tuple(imus)), self.findings, self.white)


def check_samples(recording: Recording) -> SampleChecks:
    """Return what the raw samples of a recording say."""
    checks = [raw.check(imu, recording.free_swings) for imu in recording.imus]
    checks += [raw.check_encoder(encoder) for encoder in recording.encoders]
    said = [f for c in checks for f in c.findings]
    masks = {name: ~mask for c in checks for name, mask in c.masks.items() if mask.any()}
    of_poses, wander = correlated_poses(recording)
    masks |= of_poses
    stops = [f for f in said if traits_of(f.effect).fault is Fault.STRUCK and stop_like(recording, f)]
    firm = tuple(_finding(f) for f in said if f not in stops)
    stops = [replace(f, confidence=CONFIDENCE.doubtful) if jolted(recording.imu(f.at), f) else f for f in stops]
    struck = {name.split(".")[0]: mask for c in checks for name, mask in c.struck.items() if mask.any()}
    white = {name: std for c in checks for name, std in c.white.items() if std <= MOST_REST_STD[name.split(".")[1]]}
    rest = {name: std for c in checks for name, std in c.rest.items()}
    white |= {name: std for name, std in rest.items() if white.get(name, np.inf) > NOISE_FLOOR.steady_power * std}
    notes = tuple(f.evidence for f in said)
    return SampleChecks(firm, masks, tuple(_finding(f) for f in stops), struck, notes, white, wander, rest)


def stop_like(recording: Recording, knocks: RawFinding) -> bool:
    """Return whether every knock falls into a free swing, where an end stop knocks as well."""
    times = np.atleast_1d(knocks.parameters["times"][0])
    inside = [any(a <= t <= b for a, b in recording.free_swings) for t in times]
    return recording.body is not None and bool(inside) and all(inside)


def jolted(imu: Imu, knocks: RawFinding) -> bool:
    """Return whether the gyroscope jumps where most knocks are: what strikes a sensor alone turns no segment.

    Lines through what it reads before and after meet with a step of 2 and 4 rad/s where a pendulum strikes a stop.
    """
    steps = []
    for start in np.atleast_1d(knocks.parameters["times"][0]):
        ends = []
        for at in (start - SCREENING.straight_s, start + SCREENING.knock_s):
            near = (imu.time >= at) & (imu.time <= at + SCREENING.straight_s)
            if near.sum() > 1:
                ends.append(np.polyfit(imu.time[near] - start - SCREENING.knock_s / 2, imu.gyro[near], 1)[1])
        if len(ends) == 2:
            steps.append(float(np.linalg.norm(ends[1] - ends[0])))
    return bool(steps) and float(np.median(steps)) > SCREENING.jolt_rad_s


def _finding(f: RawFinding) -> Finding:
    """Return a raw check's result as a finding; it comes from the samples alone, so nothing is held out."""
    parameters = {name: Parameter(value, std, unit) for name, (value, std, unit) in f.parameters.items()}
    return Finding(f.effect, f.at, f.confidence, parameters, Interval(0.0, (0.0, 0.0)))


def with_sample_noise(
    recording: Recording, findings: tuple[Finding, ...], white: Mapping[str, float] | None = None
) -> Recording:
    """Return the recording with its noise declared as the raw samples have it, rounding in it.

    What nobody declares is what they show above the motion. Two IMUs on one motion do not tell: at half the noise of
    one and more at the other a motion that is free fits them as well.
    """
    imus = []
    for imu in recording.imus:
        own = [f for f in findings if f.at == imu.name]
        seen = white or {}
        gyro = _level(imu.gyro_noise_std, own, "gyro", "rad/s") or seen.get(f"{imu.name}.gyro")
        accel = _level(imu.accel_noise_std, own, "accel", "m/s^2") or seen.get(f"{imu.name}.accel")
        imus.append(replace(imu, gyro_noise_std=gyro, accel_noise_std=accel))
    return replace(recording, imus=tuple(imus))


def _level(told: float | None, findings: list[Finding], part: str, unit: str) -> float | None:
    """Return the noise std of one triple, declared as `told`, with what its samples say of it; None: undeclared."""
    if not told:
        return None
    faults = [(f, traits_of(f.effect)) for f in findings]
    loud = [float(f.parameters["std"].value) for f, t in faults if t.fault is Fault.NOISY and t.channel == part]
    steps = [f.parameters["step"] for f, t in faults if t.fault is Fault.ROUNDED]
    rounding = max([0.0, *(float(p.value) / float(np.sqrt(12)) for p in steps if p.unit == unit)])
    return float(np.hypot(max([told, *loud]), rounding))
