"""What the raw samples of a recording say before any fit: findings, and which samples a fit leaves out."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from imubench.diagnosis import raw
from imubench.diagnosis.raw_findings import RawFinding
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.diagnosis.thinned import pose_masks
from imubench.recording import Recording


@dataclass(frozen=True)
class Sampled:
    """The raw checks of every IMU and encoder together."""

    findings: tuple[Finding, ...]
    masks: dict[str, NDArray[np.bool_]]  # "imu1.gyro" -> samples (n,) that count
    unless_stopped: tuple[Finding, ...] = ()  # knocks that are findings only where no end stop is
    struck: dict[str, NDArray[np.bool_]] = field(default_factory=dict)  # "imu1" -> (n,) the part of masks that is peaks
    notes: tuple[str, ...] = field(default=())

    @property
    def humming(self) -> dict[str, float]:
        """The IMUs that hum, and at how many Hz."""
        return {f.at: float(f.parameters["frequency"].value) for f in self.findings if f.effect == "vibration"}


def sampled(recording: Recording) -> Sampled:
    """Return what the raw samples of a recording say."""
    checks = [raw.check(imu, recording.free_swings) for imu in recording.imus]
    checks += [raw.check_encoder(encoder) for encoder in recording.encoders]
    said = [f for c in checks for f in c.findings]
    masks = {name: ~mask for c in checks for name, mask in c.masks.items() if mask.any()} | pose_masks(recording)
    stops = [f for f in said if f.effect == "impacts" and stop_like(recording, f)]
    firm = tuple(_finding(f) for f in said if f not in stops)
    struck = {name.split(".")[0]: mask for c in checks for name, mask in c.struck.items() if mask.any()}
    return Sampled(firm, masks, tuple(_finding(f) for f in stops), struck, tuple(f.evidence for f in said))


def stop_like(recording: Recording, knocks: RawFinding) -> bool:
    """Return whether every knock falls into a free swing, where an end stop knocks as well."""
    times = np.atleast_1d(knocks.parameters["times"][0])
    inside = [any(a <= t <= b for a, b in recording.free_swings) for t in times]
    return recording.body is not None and bool(inside) and all(inside)


def _finding(f: RawFinding) -> Finding:
    """Return a raw check's result as a finding; it comes from the samples alone, so nothing is held out."""
    parameters = {name: Parameter(value, std, unit) for name, (value, std, unit) in f.parameters.items()}
    return Finding(f.effect, f.at, f.confidence, parameters, Interval(0.0, (0.0, 0.0)))


def heard(recording: Recording, findings: tuple[Finding, ...]) -> Recording:
    """Return the recording with its noise declared as the raw samples have it, rounding in it."""
    imus = []
    for imu in recording.imus:
        own = [f for f in findings if f.at == imu.name]
        gyro, accel = (_level(own, part, unit) for part, unit in (("gyro", "rad/s"), ("accel", "m/s^2")))
        known = (imu.gyro_noise_std, imu.accel_noise_std)
        both = (gyro(known[0]) if known[0] else None, accel(known[1]) if known[1] else None)
        imus.append(replace(imu, gyro_noise_std=both[0], accel_noise_std=both[1]))
    return replace(recording, imus=tuple(imus))


def _level(findings: list[Finding], part: str, unit: str) -> Callable[[float], float]:
    """Return how a declared noise std of one triple is to be read."""
    loud = [float(f.parameters["std"].value) for f in findings if f.effect == f"{part}_noise"]
    steps = [f.parameters["step"] for f in findings if f.effect == "quantisation"]
    rounding = max([0.0, *(float(p.value) / float(np.sqrt(12)) for p in steps if p.unit == unit)])
    return lambda told: float(np.hypot(max([told, *loud]), rounding))
