"""Which screenings of effects with a life of their own are worth a refit, in which order, and begun where."""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.criteria.dynamic_score import Screened
from imubench.diagnosis.criteria.trial import kind

ANYWAY = -np.inf  # nat: no promise is asked for
LONE = 2  # filters on a lone IMU that are tried whatever they promise
RIVAL_SHARE = 0.3  # of the best one's promise: a state effect below is not worth a refit


def promising(screened: list[Screened], least: float, lone: bool, puzzling: bool = False) -> list[list[Screened]]:
    """Return the screenings worth a refit: those that promise most, then, should none of them be any good, the next.

    With `least` of `ANYWAY` the first, whatever they promise. So also a filter on a `lone` IMU: the motion is known
    only from what came out of the filter, and a screening does not see what would have gone in. A promise is one linear
    step, and so may be far too small. Where much is left (`puzzling`) the next include those whose law the motion goes
    against.
    """
    if least == ANYWAY:
        return [first(screened)]
    hopeful = [s for s in screened if s.evidence > least and s.amount > 0]
    likely = first([s for s in hopeful if s.evidence > RIVAL_SHARE * hopeful[0].evidence])
    if lone:
        filters = [s for s in screened if s.hypothesis.effect.filters and s not in likely]
        likely += sorted(filters, key=lambda s: -len(s.hypothesis.effect.states))[:LONE]  # of both triples first
    then = first([s for s in hopeful if s not in likely])
    return [likely, then + (against_law(screened, least, likely) if puzzling else [])]


def first(screened: list[Screened]) -> list[Screened]:
    """Return the screenings of the first `ADMISSION.refits` effects, the variants of one counted as one."""
    kinds = list(dict.fromkeys(kind(s.hypothesis) for s in screened))[: ADMISSION.refits]
    return [s for s in screened if kind(s.hypothesis) in kinds]


def against_law(screened: list[Screened], least: float, tried: list[Screened]) -> list[Screened]:
    """Return more screenings worth a refit, though the motion goes against their laws; begun where they promise most.

    Where springs resonate, a fit without them has their motion in the body's, partly with the wrong sign.
    """
    best = max((s.evidence for s in screened), default=0.0)
    back = [s for s in screened if s.hypothesis.effect.lawful and s.amount <= 0 and s not in tried]
    likely = [s for s in back if s.evidence > max(least, RIVAL_SHARE * best)][: ADMISSION.refits]
    return [replace(s, values=dict(s.best or s.values)) for s in likely]


def softer(one: Screened) -> Screened | None:
    """Return a screening of springs with springs half as quick to begin with; None of what has none.

    A screening holds the motion, which has already followed the springs. It promises most at too high a frequency, from
    where a refit moves on to stiff springs that are worth nothing.
    """
    quick = {name: value - np.log(2.0) for name, value in one.values.items() if name.endswith(".frequency")}
    return replace(one, values=one.values | quick) if one.hypothesis.effect.lawful and quick else None


def pairs(screened: list[Screened]) -> list[list[Screened]]:
    """Return the best two where they are of one kind at both sensors: one alone would have to stand for both."""
    of_sensors = [s for s in screened if s.hypothesis.effect.place == "imu"]
    if not of_sensors:
        return []
    best = of_sensors[0].hypothesis
    same = [s for s in of_sensors if s.hypothesis.at != best.at and s.hypothesis.effect.name == best.effect.name]
    return [[of_sensors[0], same[0]]] if same else []


__all__ = ["ANYWAY", "LONE", "RIVAL_SHARE", "pairs", "promising", "softer"]
