"""Whether two halves of a recording say the same."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.real.said import Said
from benchmarks.real.scoring import CONFIDENT, answers, names
from imubench.arrays import Array
from imubench.diagnosis.result import Finding
from imubench.score import line_deviation
from imubench.trials.match import deviation

EVENTS = ("impacts", "mount_shift", "dropouts", "saturation")
"""Effects of some moments: that one half has them says nothing of the other."""
AGREE = 3.0  # standard deviations of the difference of two numbers


@dataclass(frozen=True)
class Repeated:
    """A finding of one half, and why the other does not confirm it; empty where it does."""

    finding: str
    why: str = ""


def repeated(one: Said, other: Said, rate: float) -> list[Repeated]:
    """Return what became of the confident findings of either half in the other one; `rate` of the IMUs in Hz."""
    return [*_confirmed(one, other, rate), *_confirmed(other, one, rate)]


def _confirmed(one: Said, other: Said, rate: float) -> Iterator[Repeated]:
    pairs = zip(one.diagnosis.findings, one.material, strict=True)
    for f in (f for f, material in pairs if material and f.named and f.confidence >= CONFIDENT):
        if f.effect in EVENTS:
            continue
        what = f"{f.effect} at {f.at}"
        same = next((g for g in other.sure if (g.effect, g.at) == (f.effect, f.at)), None)
        if same is None:
            twin = next((g for g in other.sure if g.named and names(g, answers(f))), None)
            yield Repeated(what, "" if twin is not None else "not there")
        else:
            yield Repeated(what, apart(f, same, rate))


def apart(one: Finding, other: Finding, rate: float) -> str:
    """Return which number of two findings of one effect differs most, if by more than it may; else an empty text."""
    worst, most = "", AGREE
    for name, p in one.parameters.items():
        q = other.parameters.get(name)
        off = None if q is None else deviation(one.effect, name, p, q.value, rate)
        if q is None or off is None:
            continue
        std = np.hypot(_as(p.std, off), _as(q.std, off))
        z = float(np.max(np.abs(off) / np.maximum(std, 1e-300), initial=0.0))
        if z > most:
            worst, most = f"{name} {z:.0f} std apart" if z < 1e6 else f"{name} apart", z
    return worst


def _as(std: Array, off: Array) -> Array:
    """Return standard deviations in the shape of a difference; one for all where there are several for one."""
    return np.asarray(std.reshape(off.shape) if std.size == off.size else np.full(off.shape, std.max(initial=0.0)))


def moved(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Array]:
    """Return by how much the axes (2,) rad of each estimator differ between two halves, signs apart."""
    both = [name for name in one if "value" in _of(one, name) and "value" in _of(other, name)]
    return {name: np.asarray(line_deviation(one[name]["value"], other[name]["value"])) for name in both}


def _of(said: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = said.get(name, {})
    return found if isinstance(found, Mapping) else {}
