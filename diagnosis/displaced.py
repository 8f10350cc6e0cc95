"""Named effects that only stand in for something without a name: held against terms in their place."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.diagnosis.blocks import NotPositiveDefiniteError
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.fitted_terms import MOST, NEEDED, Fitted, fitted
from imubench.diagnosis.model import Hypothesis
from imubench.diagnosis.refit import log_evidence, refit
from imubench.diagnosis.term_scores import colour, promising

MUCH = 0.1  # of what names explain: a curve holds a scale too, and takes its place for no little of something else


def displaced(fit: Fit, say: Callable[[str], None] = lambda _: None) -> tuple[list[Fitted], Fit]:
    """Return terms that explain more than the named effects where they are, and the fit with them instead.

    What goes with shaking has a mean, and reads as a bias until it is held against one.
    """
    found: list[Fitted] = []
    for gone in groups(fit.model.hypotheses):
        if len(found) == MOST or not set(gone) <= set(fit.model.hypotheses):
            continue
        say(f"looking whether something without a name explains more than {' and '.join(h.name for h in gone)}")
        with suppress(NotPositiveDefiniteError):
            without = refit(fit, tuple(h for h in fit.model.hypotheses if h not in gone), steps=4)
            guesses, tried = promising(without)
            named = log_evidence(fit)
            price, lost = float(np.log(max(tried, 1))), named - log_evidence(without)
            better = [g for g in guesses if g.term.at == seen_at(gone[0]) and not g.term.drift]
            if better and better[0].evidence > lost + NEEDED + price:
                done = fitted(without, better[0], price)
                louder = colour(done.fit, done.term)
                more = (log_evidence(done.fit) - named) / louder - price
                if more > max(NEEDED, MUCH * lost / louder) and done.heldout.low > 0:
                    found, fit = [*found, replace(done, evidence=more)], done.fit
    return found, fit


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
