"""The chain that a diagnosis found: every finding as an effect with its numbers, settings and signals, to be played."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.correction.sensor_chain import Effects, Link
from imubench.diagnosis.evidence import FittedEffect
from imubench.diagnosis.result import UNKNOWN, Finding
from imubench.effects import EFFECTS, traits_of
from imubench.effects.traits import Fault
from imubench.recording import Imu, Recording


def chain_of(findings: Iterable[Finding], fitted: Sequence[FittedEffect], recording: Recording) -> Effects:
    """Return the place and the effect of every finding, those with a name first.

    Args:
        findings: with the numbers that a report names.
        fitted: the same effects with all their numbers and signals; terms without a name, several to a place.
        recording: as it came; its samples show how some of them are lost.
    """
    found = tuple(findings)
    named = [(f.at, link_of(f, fitted, recording)) for f in found if f.named]
    strange = dict.fromkeys(f.at for f in found if not f.named)
    return (*named, *((at, summed([own for own in fitted if (own.effect, own.at) == (UNKNOWN, at)])) for at in strange))


def link_of(f: Finding, fitted: Sequence[FittedEffect], recording: Recording) -> Link:
    """Return a finding as an effect with its numbers: those of the report, and beside them those that the fit has."""
    own = next((own for own in fitted if (own.effect, own.at) == (f.effect, f.at)), None)
    values: dict[str, Array] = dict(own.values) if own is not None else {}
    time, signals = np.zeros(0), {}
    law = EFFECTS.get(f.effect)
    if own is not None and law is not None and law.acts("encoder"):  # at the recording's start its states are numbers
        time, signals = own.time, dict(own.signals)
        values |= {name: np.asarray(np.interp(0.0, time, x[:, 0])) for name, x in signals.items()}
    values |= {name: p.value for name, p in f.parameters.items()}
    return Link(f.effect, values, settings_of(f, own, recording), time, signals)


def settings_of(f: Finding, own: FittedEffect | None, recording: Recording) -> dict[str, Any]:
    """Return the channels of an effect that has some, and how samples are lost.

    The samples themselves show how: a finding tells a number and its unit.
    """
    if own is not None and own.settings.get("channels"):
        return {"channels": list(own.settings["channels"])}  # type: ignore[arg-type]
    fault = traits_of(f.effect).fault
    if fault in (Fault.CLIPPED, Fault.ROUNDED):
        unit = next(iter(f.parameters.values())).unit
        return {"channels": ["gyro" if unit == "rad/s" else "accel"]}
    if fault is Fault.LOST:
        imus = [imu for imu in recording.imus if imu.name == f.at]
        share = float(f.parameters["fraction"].value)
        return {"mode": "held" if imus and 2 * held_share(imus[0]) > share else "missing"}
    return {}


def held_share(imu: Imu) -> float:
    """Return the share of an IMU's samples that say the one before again."""
    same = (np.diff(imu.gyro, axis=0) == 0).all(axis=1) & (np.diff(imu.accel, axis=0) == 0).all(axis=1)
    return float(same.mean())


def summed(terms: Sequence[FittedEffect]) -> Link:
    """Return what several terms without a name at one place add, as one signal; nothing where none was fitted."""
    if not terms:
        return Link(UNKNOWN, {})
    time = terms[0].time
    signals: dict[str, Array] = {}
    for part in dict.fromkeys(part for f in terms for part in f.signals):
        each = [(f.time, f.signals[part]) for f in terms if part in f.signals]
        signals[part] = np.sum([[np.interp(time, t, c) for c in x.T] for t, x in each], axis=0).T
    return Link(UNKNOWN, {}, {}, time, signals)


__all__ = ["chain_of", "link_of"]
