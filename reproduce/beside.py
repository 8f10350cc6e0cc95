"""Estimators that a user names, on a paper's recordings, beside the paper's own method."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from imubench.attempt import Failed, attempted, own_apart
from imubench.errors import InputError
from imubench.figures import DEFAULTS, of_quantity, value_of
from imubench.plugin_versions import absolute, loaded, versions
from imubench.plugins import find_estimator
from imubench.recording import Recording
from imubench.reproduce.paper import Arrays, Paper, Part, Table, Trial
from imubench.score import score
from imubench.truth import Truth
from imubench.units import SHOWN

SECONDS = 60.0
"""s by the clock for one estimate, as in a sweep; ours take seconds for the longest recording, of twelve minutes."""
WORK = 5.0  # s of one estimate, to pace the bar


@dataclass(frozen=True)
class Asked:
    """The paper's method and the estimators to stand beside it, as other processes find them."""

    trials: tuple[Trial, ...]
    places: Mapping[str, str]  # as asked for -> as found from any folder; the paper's own method first
    versions: Mapping[str, str]
    figure: str
    seconds: float = SECONDS  # by the clock, for one estimate

    @property
    def identity(self) -> list[tuple[str, str]]:
        """What tells this from other estimators, or other versions of them, or less time for them."""
        return [*((name, self.versions[name]) for name in self.places), ("seconds", f"{self.seconds:g}")]


@dataclass(frozen=True)
class Outcome:
    """What an estimator came to on one recording."""

    trial: str
    estimator: str
    error: float | None  # rad or m
    best_pairing: bool  # the error is that of the better of two sign pairings
    why: str  # a line, where there is no error


def asked_for(paper: Paper, settings: object, estimators: Sequence[str], seconds: float | None = None) -> Asked | None:
    """Return what is to be done for the estimators of `--estimator`; None where there are none.

    Raises:
        InputError: a paper whose recordings no other estimator can be given, an estimator that is none, or one that
            answers another question than the paper's.
    """
    if not estimators:
        return None
    if not paper.method:
        raise InputError(f"--estimator: expected a paper whose recordings others can be given, got {paper.name}")
    names = list(dict.fromkeys((paper.method, *estimators)))
    quantity = find_estimator(paper.method).quantity
    for name in names:
        other = find_estimator(name).quantity
        if other not in (None, quantity):
            raise InputError(f"--estimator {name}: expected one of the {quantity}, as {paper.name} is, got a {other}")
    places = {name: absolute(name) for name in names}
    return Asked(
        tuple(paper.trials(settings)), places, versions(places), DEFAULTS[quantity or "joint_axis"], seconds or SECONDS
    )


def parts(asked: Asked) -> list[Part]:
    """Return the work: each estimator on each recording."""
    return [
        Part(
            f"beside-{i}-{k}",
            "estimators beside the paper's",
            WORK,
            estimated,
            {
                "play": trial.play,
                "arguments": dict(trial.arguments),
                "name": name,
                "place": place,
                "version": asked.versions[name],
                "figure": asked.figure,
                "seconds": asked.seconds,
            },
        )
        for i, trial in enumerate(asked.trials)
        for k, (name, place) in enumerate(asked.places.items())
    ]


def estimated(
    play: Callable[..., tuple[Recording, Truth]],
    arguments: Mapping[str, Any],
    name: str,
    place: str,
    version: str,
    figure: str,
    seconds: float,
) -> Arrays:
    """Return `error` in rad or m, NaN without one, `best_pairing`, and `why` there is none, of one estimate."""
    recording, truth = play(**arguments)
    answer = attempted(loaded(name, place, version), recording, seconds, own_apart())
    if isinstance(answer, Failed):
        return _arrays(math.nan, False, f"{answer.status}: {answer.why}")
    error, best = value_of(score(answer, truth), figure)
    return _arrays(math.nan if error is None else error, best, "" if error is not None else f"it has no {figure}")


def _arrays(error: float, best: bool, why: str) -> Arrays:
    return {"error": np.array(error), "best_pairing": np.array(best), "why": np.array(why)}


def outcomes(asked: Asked, done: Mapping[str, Arrays]) -> list[Outcome]:
    """Return what came of every estimator on every recording."""
    found = []
    for i, trial in enumerate(asked.trials):
        for k, name in enumerate(asked.places):
            arrays = done[f"beside-{i}-{k}"]
            error = float(arrays["error"])
            missing = math.isnan(error)
            best = bool(arrays["best_pairing"])
            found.append(Outcome(trial.name, name, None if missing else error, best, str(arrays["why"])))
    return found


def finding(asked: Asked, found: Sequence[Outcome]) -> str:
    """Return the median error of each estimator in a sentence; no answer counts as an infinite error."""
    unit, factor = _shown(asked)
    told = []
    for name in asked.places:
        errors = [math.inf if o.error is None else o.error for o in found if o.estimator == name]
        median = float(np.quantile(errors, 0.5, method="higher"))
        told.append(f"{name} {f'{factor * median:.2g} {unit}' if math.isfinite(median) else 'no answer'}")
    return f"Median error on {len(asked.trials)} recordings: {', '.join(told)}"


def table(asked: Asked, found: Sequence[Outcome]) -> Table:
    """Return the errors, a row a recording and a column an estimator; of what failed, how."""
    unit, factor = _shown(asked)
    by_place = {(o.trial, o.estimator): o for o in found}

    def cell(o: Outcome) -> str:
        return o.why.partition(":")[0] if o.error is None else f"{factor * o.error:.3g}{'*' if o.best_pairing else ''}"

    rows = tuple((t.name, *(cell(by_place[t.name, name]) for name in asked.places)) for t in asked.trials)
    text = (
        f"Each is given a whole recording of the paper and nothing else. Errors ({asked.figure}) in {unit}. With a "
        "star: the estimate leaves open how the signs of the axes go together, and is judged by the better of both."
    )
    return Table("beside", "Other estimators", finding(asked, found), text, ("recording", *asked.places), rows)


def as_list(asked: Asked, found: Sequence[Outcome]) -> list[dict[str, Any]]:
    """Return all of it for beside.json; errors in rad or m."""
    return [
        {
            "recording": o.trial,
            "estimator": o.estimator,
            "figure": asked.figure,
            "unit": _unit(asked),
            "error": o.error,
            "best_pairing": o.best_pairing,
            "why": o.why,
        }
        for o in found
    ]


def _unit(asked: Asked) -> str:
    return next(units[asked.figure] for units in map(of_quantity, DEFAULTS) if asked.figure in units)


def _shown(asked: Asked) -> tuple[str, float]:
    return SHOWN[_unit(asked)]
