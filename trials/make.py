"""A case made by the independent generator, with what its truth needs to be scored: other right answers, bounds."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from imubench.errors import InputError
from imubench.proof.beyond import beyond
from imubench.proof.bounds import NOT_ESTIMATED, bounds
from imubench.proof.case import build
from imubench.proof.mixture import Question, make
from imubench.proof.options import Effect, Options
from imubench.proof.played import Case
from imubench.proof.ranges import twins
from imubench.proof.told import plain, told
from imubench.trials.seal import Truth

NO_BOUND = ("impacts", "moving_pivot", "joint_play")  # no parameter, or one of a motion that is itself random
UNSEEN = 1e5  # times a parameter's size: a bound above that is none
FILES = ("recording.toml", "imu1.csv", "imu2.csv", "encoder.csv", "pose1.csv", "pose2.csv", "reference.csv")


def shortened(question: Question, seconds: float | None) -> Question:
    """Return the question with at most so many seconds of recording."""
    if seconds is None or question.options["seconds"] <= seconds:
        return question
    return replace(question, options=question.options | {"seconds": seconds})


def made(question: Question, folder: Path) -> Truth:
    """Write the recording of a question into the new folder, and return its truth, which no file holds."""
    truth = make(question, folder)
    case = rebuilt(truth)
    truth["answers"] = [answers(e, case.options) for e in case.effects]
    truth["freedom"] = [freedom(e) for e in case.effects]
    truth["bounds"] = [
        None if e.effect in NO_BOUND or not e.inside else bounds(case, i) for i, e in enumerate(case.effects)
    ]
    truth["bounds"] = [_finite(b, e) for b, e in zip(truth["bounds"], case.effects, strict=True)]
    truth["neighbour"] = beyond(case) if truth["kind"] == "outside" else None
    return truth


def rebuilt(truth: Truth) -> Case:
    """Return the generator's case that a truth is of."""
    options = dict(truth["options"])
    effects = [(e["effect"], e["at"], e["parameters"] | e["detail"]) for e in truth["effects"]]
    return build(options.pop("rig"), effects, truth["seed"], **options)


def answers(effect: Effect, options: Options) -> list[dict[str, Any]]:
    """Return what is a right answer for an effect: itself, then its twins; a twin without parameters has {}."""
    return [told(e) for e in (effect, *twins([effect], options))]


def freedom(effect: Effect) -> int:
    """Return how many numbers of an effect would be estimated."""
    return sum(int(np.size(value)) for key, value in effect.parameters.items() if key not in NOT_ESTIMATED)


def _finite(found: Mapping[str, Any] | None, effect: Effect) -> dict[str, Any] | None:
    """Return bounds as JSON can hold them, without those of parameters that cannot be seen."""
    if found is None:
        return None
    seen = {}
    for key, bound in found.items():
        size = max(float(np.abs(np.asarray(effect.parameters[key], dtype=float)).max()), 1e-9)
        seen[key] = np.where(np.asarray(bound) < UNSEEN * size, bound, -1.0)
    return {key: plain(bound) for key, bound in seen.items() if np.all(bound > 0)}


def leaks(folder: Path, truth: Truth) -> list[str]:
    """Return how a recording would tell its truth: file names, text and numbers that do not belong into one."""
    found = [f"file '{p.name}'" for p in sorted(folder.rglob("*")) if p.name not in FILES]
    if folder.name != "recording":
        found.append(f"folder '{folder.name}'")
    header = "\n".join(p.read_text(encoding="utf-8") for p in sorted(folder.glob("*.toml")))
    words = {e["effect"] for e in truth["effects"]} | {truth["kind"], truth["strength"]}
    found += [f"word '{w}' in recording.toml" for w in sorted(words) if w in _values(header)]
    if str(truth["seed"]) in header:
        found.append("the seed in recording.toml")
    for table in sorted(folder.glob("*.csv")):
        with table.open(encoding="utf-8") as lines:
            if not set(next(lines).strip().split(",")) <= COLUMNS:
                found.append(f"columns of {table.name}")
    return found


def refuse_leaks(folder: Path, truth: Truth) -> None:
    """Raise `InputError` where a recording tells its truth."""
    found = leaks(folder, truth)
    if found:
        raise InputError(f"{folder}: expected a recording that does not tell its truth, got {', '.join(found)}")


COLUMNS = {
    "time", "angle", "x", "y", "z", "qw", "qx", "qy", "qz", "hinge_angle", "joint_x", "joint_y", "joint_z",
    *(f"{kind}_{axis}" for kind in ("gyr", "acc") for axis in "xyz"),
    *(f"q{i}_{axis}" for i in (1, 2) for axis in "wxyz"),
}  # fmt: skip


def _values(header: str) -> set[str]:
    """Return the words of the text values in a TOML file, keys left out."""
    values = (line.split("=", 1)[-1] for line in header.splitlines() if "=" in line)
    return {word for value in values for word in "".join(c if c.isalnum() or c == "_" else " " for c in value).split()}
