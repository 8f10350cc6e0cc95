"""Whether a finding is right: names and places, what the interface calls equivalent, and parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.result import Finding, Parameter
from imubench.models.tree import rig_tree
from imubench.trials.seal import Truth

Answers = Sequence[Mapping[str, Any]]
"""What is right for one effect: itself and its twins, each with `effect`, `at`, `parameters`."""


ABOUT_A_HEADING = {"end_stop": ("angle",), "joint_spring": ("q0",), "skin_sliding": ("slide", "twist")}
"""What is along or per angle of a pendulum's swing, whose sign turns with the heading; free without a magnetometer."""


@dataclass(frozen=True)
class ParameterError:
    """One parameter of one finding: how far off it is."""

    effect: str
    parameter: str
    over_std: tuple[float, ...]  # error of each number over its stated standard deviation
    over_bound: tuple[float, ...] | None  # over the Cramer-Rao bound, where there is one


def sure(findings: Sequence[Finding]) -> list[Finding]:
    """Return the findings that count."""
    return [f for f in findings if f.confidence >= CONFIDENCE.counts]


def names(answers: Answers, effect: str, at: str) -> bool:
    """Return whether an effect at a place is right."""
    return any(a["effect"] == effect and a["at"] == at for a in answers)


def holds(answers: Answers, finding: Finding) -> bool:
    """Return whether a finding, or one of its equivalents, is right."""
    return names(answers, finding.effect, finding.at) or any(names(answers, e.effect, e.at) for e in finding.equivalent)


def paired(truth: Truth, findings: Sequence[Finding]) -> dict[int, Finding]:
    """Return the finding for each effect of the table by its index, no finding for two of them.

    As many pairs as there can be (augmenting paths); a finding that says the name itself comes before one that has
    it among its equivalents.
    """
    named = [f for f in findings if f.named]
    taken: dict[int, int] = {}  # finding -> effect

    def options(effect: int) -> list[int]:
        answers = truth["answers"][effect]
        direct = [k for k, f in enumerate(named) if names(answers, f.effect, f.at)]
        return direct + [k for k, f in enumerate(named) if k not in direct and holds(answers, f)]

    def place(effect: int, tried: set[int]) -> bool:
        for k in options(effect):
            if k not in tried:
                tried.add(k)
                if k not in taken or place(taken[k], tried):
                    taken[k] = effect
                    return True
        return False

    for i in inside(truth):
        place(i, set())
    return {effect: named[k] for k, effect in taken.items()}


def inside(truth: Truth) -> list[int]:
    """Return the indices of the effects that the table has."""
    return [i for i, effect in enumerate(truth["effects"]) if effect["inside"]]


def true(truth: Truth, findings: Sequence[Finding], finding: Finding) -> bool:
    """Return whether what a finding says is there is there.

    A named one: an effect with its name and place, or with one of its equivalents', or a name that no method tells from
    the physics outside the table. An unknown: something that no other sure finding names.
    """
    if finding.named:
        neighbour = truth.get("neighbour") or {"same": ()}
        alike = f"{finding.effect} at {finding.at}" in neighbour["same"]
        return alike or any(holds(truth["answers"][i], finding) for i in inside(truth))
    return len(paired(truth, sure(findings))) < len(truth["effects"])


def parameter_errors(truth: Truth, effect: int, finding: Finding) -> list[ParameterError]:
    """Return the errors of the parameters that both sides give; [] where the finding names a twin without any."""
    answer = next((a for a in truth["answers"][effect] if names([a], finding.effect, finding.at)), None)
    if answer is None:
        return []
    out, bounds = [], truth["bounds"][effect] or {}
    turned = rig_tree(truth["rig"]).ball is not None and other_way(answer, finding)
    for key, value in answer["parameters"].items():
        told = finding.parameters.get(key)
        if told is None or isinstance(value, str) or key in ("channels", "mode", "times", "band", "gyration"):
            continue
        true, rate = np.asarray(value, dtype=float), _rate(truth, finding.at)
        if turned and key in ABOUT_A_HEADING[finding.effect]:
            true = -true
        off = deviation(finding.effect, key, told, true, rate)
        if off is None:
            continue
        std = np.broadcast_to(told.std, off.shape)
        bound = bounds.get(key)
        limit = None
        if bound is not None and np.size(bound) == off.size:
            limit = _numbers(off.ravel() / np.ravel(bound))
        over = off.ravel() / np.maximum(std.ravel(), 1e-300)
        out.append(ParameterError(finding.effect, key, _numbers(over), limit))
    return out


def other_way(answer: dict[str, Any], finding: Finding) -> bool:
    """Return whether a pendulum's finding is true of the heading that is half a turn away: all its signs together."""
    keys = [k for k in ABOUT_A_HEADING.get(finding.effect, ()) if k in finding.parameters and k in answer["parameters"]]
    told = [(finding.parameters[k], np.asarray(answer["parameters"][k], dtype=float)) for k in keys]
    return sum(float(np.sum(p.value * true / np.maximum(p.std, 1e-300) ** 2)) for p, true in told) < 0  # least squares


def deviation(effect: str, key: str, told: Parameter, value: Array, rate: float) -> Array | None:
    """Return told minus true for a sensor of that rate in Hz; None where the shapes cannot be compared.

    A hum's amplitude has no sign; its frequency may be any image under sampling; a play's direction is an axis; one
    frequency for three axes is compared with their mean.
    """
    found = told.value
    if found.size == 1 and value.size == 3 and key in ("frequency", "damping_ratio"):
        value = np.atleast_1d(value.mean())
    if found.size == value.size:
        found = found.reshape(value.shape)
    elif not (value.size == 1 and np.ptp(found) == 0):
        return None
    if effect == "vibration" and key == "frequency":
        return np.asarray(image(found, rate) - image(value, rate))
    off = found - value
    if (effect, key) == ("vibration", "amplitude") and np.abs(found + value).max() < np.abs(off).max():
        return np.asarray(found + value)
    if effect == "joint_play" and key == "direction":
        return np.asarray((off + np.pi / 2) % np.pi - np.pi / 2)
    return np.asarray(off)


def image(frequency: Array, rate: float) -> Array:
    """Return where a frequency shows after sampling, from 0 to half the rate."""
    folded = np.mod(frequency, rate)
    return np.minimum(folded, rate - folded)


def _rate(truth: Truth, at: str) -> float:
    options = truth["options"]
    return float(options["rate2"] if at == "imu2" and options["rate2"] else options["rate"])


def _numbers(values: Array) -> tuple[float, ...]:
    return tuple(float(f"{v:.4g}") for v in np.clip(values, -1e9, 1e9))
