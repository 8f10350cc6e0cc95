"""Named effects that only stand in for something without a name: held against terms in their place."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from imubench.diagnosis.blocks import NotPositiveDefiniteError
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.fitted_terms import MOST, NEEDED, Fitted, fitted
from imubench.diagnosis.model import Hypothesis
from imubench.diagnosis.refit import log_evidence, refit
from imubench.diagnosis.term_scores import Guess, colour, promising

MUCH = 0.1  # of what names explain: a curve holds a scale too, and takes its place for no little of something else
NAMES = 60  # effects at their places: what a name was chosen from, as a term from its like


@dataclass(frozen=True)
class Displaced:
    """What terms did to the names of a fit."""

    terms: list[Fitted]
    fit: Fit  # with these in the place of the names that they explain more than
    doubted: tuple[Hypothesis, ...]  # names beside which a term explains as much, and not surely more


def displaced(fit: Fit, say: Callable[[str], None] = lambda _: None) -> Displaced:
    """Return terms that explain more than named effects, the fit with them instead, and the names that they equal.

    What goes with shaking has a mean, and reads as a bias until it is held against one.
    """
    terms: list[Fitted] = []
    doubted: list[Hypothesis] = []
    for gone in groups(fit.model.hypotheses):
        if len(terms) == MOST or not set(gone) <= set(fit.model.hypotheses):
            continue
        say(f"looking whether something without a name explains more than {' and '.join(h.name for h in gone)}")
        with suppress(NotPositiveDefiniteError):
            without = refit(fit, tuple(h for h in fit.model.hypotheses if h not in gone), steps=4)
            guesses, tried = promising(without)
            named = log_evidence(fit)
            price, lost = float(np.log(max(tried / NAMES, 1))), named - log_evidence(without)
            tried_here: list[tuple[Fitted, float]] = []  # and what a nat of white noise is worth there
            for guess in rivals(guesses, seen_at(gone[0]), lost):
                done = fitted(without, guess, price)
                louder = colour(done.fit, done.term)
                more = (log_evidence(done.fit) - named) / louder - price
                if done.heldout.low > 0 and more > 0:
                    tried_here.append((replace(done, evidence=more), 1 / louder))
            best, worth = max(tried_here, key=lambda t: t[0].evidence, default=(None, 1.0))
            if best and best.evidence > max(NEEDED, MUCH * lost * worth):
                terms, fit = [*terms, best], best.fit
            elif best:
                doubted += gone
    return Displaced(terms, fit, tuple(h for h in doubted if h in fit.model.hypotheses))


def rivals(guesses: Sequence[Guess], at: str, lost: float) -> Iterator[Guess]:
    """Return the best term and the best one at a place that promise more than `lost`; a drift has a name."""
    likely = [g for g in guesses if not g.term.drift and g.evidence > lost]
    yield from likely[:1]
    yield from [g for g in likely[1:] if g.term.at == at and likely[0].term.at != at][:1]


def groups(hypotheses: Sequence[Hypothesis]) -> list[tuple[Hypothesis, ...]]:
    """Return the effects without states that a term may displace: each alone, and together those of one triple."""
    plain = [h for h in hypotheses if not h.effect.states]
    triples: dict[tuple[str, str], list[Hypothesis]] = {}
    for h in plain:
        triples.setdefault((h.at, h.effect.name.split("_")[0]), []).append(h)
    return [(h,) for h in plain] + [tuple(some) for some in triples.values() if len(some) > 1]


def seen_at(h: Hypothesis) -> str:
    """Return where a term that stands for an effect would be: at its IMU, or in the torque of a swing."""
    return h.at if h.effect.place == "imu" else "joint"


__all__ = ["Displaced", "displaced", "groups"]
