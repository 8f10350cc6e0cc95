"""What an undisturbed recording A says of its sensors, taken over into the diagnosis of another one, B.

An IMU reads y = x + M x + s.x + A f + b, all in its own axes: x the true angular rate (gyroscope, rad/s) or specific
force f (accelerometer, m/s^2, +9.81 up at rest), b, s, M, A its bias, scale, misalignment and g-sensitivity. With z
(k,) all these numbers of one IMU, the diagnosis of A has z_A and its covariance S_A, given the motion, the mounts and
whatever else A needed (`own_errors`). Until B they change by what a sensor's numbers do, D diagonal (`of_the_sensor`
of each effect, with its source). So in B, before B is seen::

    z_B ~ N(z_A, S_A + D)

and the nominal fit of B has z_B in it (`known_errors`): what it leaves is new. An effect of one of these names that the
search then finds adds to z_B, and its numbers are the change.

What is the sensor's own but acts on no single sample (a filter), or shows in the raw samples alone (rounding, noise
above the declared), is found in B as ever, and left out where it is what A had, up to its change. A noise that nobody
declares is taken from A where A knew it and B does not.

Not the sensor's, and not taken over: mounts and all that moves on them, joints, friction; what happens (drifts,
saturation, dropouts, knocks, hums); and clocks, whose offset and rate are between two loggers and begin anew when these
are switched on.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isclose
from pathlib import Path

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.samples import NOISE_FLOOR
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.config.verdict import SAME_SENSORS
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.result import (
    NOT_KNOWN,
    Baseline,
    Diagnosis,
    Finding,
    Interval,
    Noise,
    Own,
    Parameter,
    SensorErrors,
)
from imubench.diagnosis.samples.screening import SampleChecks
from imubench.diagnosis.sensor_errors.baseline_change import allowed, changed, differ
from imubench.diagnosis.sensor_errors.own_errors import ranges_of, samplewise
from imubench.effects import EFFECTS
from imubench.effects.known import known_errors
from imubench.errors import InputError
from imubench.recording import Recording


def check_usable(d: Diagnosis, path: Path) -> None:
    """Raise `InputError` where a diagnosis says nothing of its sensors, or what no law of the table has."""
    if not d.sensors:
        raise InputError(
            f"{path}: expected a diagnosis that says what its sensors' own errors are (key 'sensors'), got none: "
            f"its verdict is '{d.verdict}'; diagnose that recording anew, or another one"
        )
    for sensor in d.sensors:
        names = [own.effect for own in sensor.errors]
        for own in sensor.errors:
            effect = EFFECTS.get(own.effect)
            if effect is None or not samplewise(effect) or names.count(own.effect) > 1:
                known = [name for name, e in EFFECTS.items() if samplewise(e)]
                raise InputError(f"{path}: {sensor.at}: expected once each of {_listed(known)}, got {_listed(names)}")
            wanted = {p.name: p.shape for p in effect.parameters}
            got = {name: p.value.shape for name, p in own.parameters.items()}
            if list(wanted.items()) != list(got.items()):
                raise InputError(f"{path}: {own.effect} at {own.at}: expected the parameters {wanted}, got {got}")
        try:
            np.linalg.cholesky(_prior(sensor))
        except np.linalg.LinAlgError:
            raise InputError(
                f"{path}: {sensor.at}: expected standard deviations and correlations of a covariance, got others"
            ) from None


def check_same_sensors(baseline: Diagnosis | Recording, recording: Recording) -> None:
    """Raise `InputError` where a baseline, or its recording, is of other sensors than a recording's.

    On another rig the same sensors have the same errors: that is no reason.
    """
    told: list[tuple[str, float, Mapping[str, float]]]
    if isinstance(baseline, Recording):
        where, told = baseline.name, [(i.name, i.rate, ranges_of(i)) for i in baseline.imus]
    else:
        where, told = baseline.recording, [(s.at, s.rate, s.ranges) for s in baseline.sensors]
    where, mine = f"baseline {where}", [imu.name for imu in recording.imus]
    if sorted(name for name, _, _ in told) != sorted(mine):
        got = _listed([name for name, _, _ in told])
        raise InputError(f"{where}: expected the sensors of {recording.name}, {_listed(mine)}, got {got}")
    for name, rate, ranges in told:
        imu = recording.imu(name)
        if abs(np.log(rate / imu.rate)) > SAME_SENSORS.same_rate:
            raise InputError(f"{where}: expected {name} at {imu.rate:g} Hz, as in {recording.name}, got {rate:g} Hz")
        for part, limit in ranges_of(imu).items():
            if part in ranges and not np.isclose(limit, ranges[part], rtol=SAME_SENSORS.same_rate):
                raise InputError(f"{where}: expected {name}'s {part} to reach {limit:g}, got {ranges[part]:g}")


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"


@dataclass(frozen=True)
class Learned:
    """What a diagnosis says of its sensors, for another recording of theirs."""

    recording: str
    sensors: tuple[SensorErrors, ...]
    told: tuple[Finding, ...]  # of the sensors' own, what does not add to single samples
    noise: Mapping[str, Noise]  # by triple, where it is known
    doubt: str = ""  # what speaks against the diagnosis it was learned from

    @classmethod
    def of(cls, d: Diagnosis) -> "Learned":
        """Return what a diagnosis says of its sensors."""
        told = (f for f in d.findings if f.named and f.confidence >= CONFIDENCE.counts)
        noise = {name: n for name, n in d.noise.items() if n.source != NOT_KNOWN and name.startswith("imu")}
        doubt = f"it was stopped by the {d.stopped}" if d.stopped else ""
        if d.doubts:
            doubt = f"its model is doubted: {d.doubts[0].of}: {d.doubts[0].why}"
        return cls(d.recording, d.sensors, tuple(f for f in told if _elsewise(f.effect)), noise, doubt)

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """The errors of every IMU as the nominal model of another recording has them."""
        return tuple(
            Hypothesis(known_errors([EFFECTS[own.effect] for own in s.errors], s.value, _prior(s)), s.at)
            for s in self.sensors
        )

    @property
    def record(self) -> Baseline:
        """What is taken over, in the words of diagnosis.json."""
        errors = [_wider(own) for s in self.sensors for own in s.errors]
        told = (_wider(Own(f.effect, f.at, f.parameters)) for f in self.told)
        return Baseline(self.recording, (*errors, *told), self.doubt)

    def on(self, samples: SampleChecks) -> SampleChecks:
        """Return what raw samples show, with the noise of sensors that the earlier recording alone knows."""
        quieter = {
            name: n.std
            for name, n in self.noise.items()
            if name not in samples.rest and samples.white.get(name, np.inf) > NOISE_FLOOR.steady_power * n.std
        }
        return replace(samples, white=samples.white | quieter, rest=samples.rest | quieter)

    def known(self, noise: Mapping[str, Noise]) -> dict[str, Noise]:
        """Return noise by triple, what is known from the earlier recording as it was known there."""
        return {
            name: self.noise[name] if name in self.noise and isclose(n.std, self.noise[name].std) else n
            for name, n in noise.items()
        }

    def new(self, findings: Sequence[Finding]) -> tuple[Finding, ...]:
        """Return findings without what the sensors had before, and of what has changed the change."""
        out = []
        for f in findings:
            own = next((o for o in self.told if alike(f, o)), None)
            if own is None:
                out.append(f)
            elif differ(f, own, EFFECTS[f.effect].of_the_sensor):
                out.append(changed(f, own))
        return tuple(out)


def alike(one: Finding, other: Finding) -> bool:
    """Return whether two findings are of one effect, place and channel, which the units tell."""
    units = [{name: p.unit for name, p in f.parameters.items()} for f in (one, other)]
    return (one.effect, one.at) == (other.effect, other.at) and units[0] == units[1]


def whole(d: Diagnosis) -> tuple[Finding, ...]:
    """Return a diagnosis' findings with all errors that its sensors have, those that a baseline told included.

    Of errors that add up, what a finding says is the change, and what the diagnosis says of the sensors the sum.
    """
    if d.baseline is None:
        return d.findings
    known = [own for s in d.sensors for own in s.errors]
    known += [own for own in d.baseline.taken_over if _elsewise(own.effect)]
    told = {(own.effect, own.at) for s in d.sensors for own in s.errors}
    none = Interval(0.0, (0.0, 0.0))
    rest = (f for f in d.findings if (f.effect, f.at) not in told)
    return (*rest, *(Finding(o.effect, o.at, 1.0, o.parameters, none, material=False) for o in known))


def _elsewise(name: str) -> bool:
    effect = EFFECTS.get(name)
    return effect is not None and effect.of_the_sensor is not None and not samplewise(effect)


def _prior(sensor: SensorErrors) -> Array:
    """Return the covariance (k, k) of a sensor's errors in another recording of it."""
    change = [_change(own, p).ravel() for own in sensor.errors for p in own.parameters.values()]
    return np.asarray(sensor.covariance + np.diag(np.concatenate([np.zeros(0), *change]) ** 2))


def _change(own: Own, p: Parameter) -> Array:
    """Return how far a parameter's numbers go from one recording to the next, as standard deviations."""
    return allowed(p, EFFECTS[own.effect].of_the_sensor)


def _wider(own: Own) -> Own:
    """Return an effect with the standard deviations that it has in another recording."""
    return replace(
        own,
        parameters={
            name: Parameter(p.value, np.hypot(p.std, _change(own, p)), p.unit) for name, p in own.parameters.items()
        },
    )


__all__ = ["Learned", "check_same_sensors", "check_usable", "whole"]
