"""The best term without a name on a fit: of those that promise enough refitted exactly, one that predicts."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.discrepancy import TERM
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.discrepancy.drift_tests import SlowErrors
from imubench.diagnosis.discrepancy.fitted_terms import fitted_term
from imubench.diagnosis.discrepancy.term_scores import FittedTerm, Guess, promising
from imubench.diagnosis.discrepancy.terms import SERIES
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import CHANNELS
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.threads import one_thread


def best_term(fit: Fit) -> FittedTerm | None:
    """Return the best term with its refit, None where none has the evidence or predicts.

    What is at one sensor can look like a term at another until it is fitted: the best of each place are refitted, and
    the one that predicts most is it. A walk foretells little of itself: that its shape tells is enough, and where it
    is.
    """
    guesses, tried = promising(fit)
    price = float(np.log(max(tried, 1)))
    untold = SERIES if follows_lone_accelerometer(fit) else ()
    told = [g for g in with_shape_gains(fit, guesses, TERM.shape_nat + price) if g.term.goes_with not in untold]
    likely = [g for g in told if believable(g.evidence - price, g.shape)]
    places = [next(g for g in likely if g.term.at == at) for at in dict.fromkeys(g.term.at for g in likely)]
    rivals = [g for g in places if g.white > TERM.rival * likely[0].white]
    others = [g for g in likely if g not in rivals]
    good: list[FittedTerm] = []
    for guess in (*rivals, *others[: max(TERM.likely - len(rivals), 0)]):
        if good and guess not in rivals:
            break
        with suppress(NotPositiveDefiniteError):
            done = fitted_term(fit, guess, price)
            if believable(done.evidence, done.shape) and (done.heldout.is_sure() or needs_no_cross_validation(done)):
                good.append(done)
    best = max(good, key=lambda f: f.heldout.value, default=None)
    return max((f for f in good if f.term.drift), key=lambda f: f.shape) if best and best.term.drift else best


def believable(evidence: float, shape: float) -> bool:
    """Return whether a term is worth enough nat, or its shape is."""
    return evidence > EVIDENCE.clear_nat or shape > TERM.shape_nat


def needs_no_cross_validation(done: FittedTerm) -> bool:
    """Return whether a term need not be foretold: a slow error of a clear shape, or a mount that turns and loses none.

    A mount that creeps is worth less beside coloured noise than what it gains on left-out seconds may differ by chance,
    so the held-out test cannot decide; without a creep such a turn loses.
    """
    return done.shape > EVIDENCE.certain_nat or (done.term.part == "both" and done.heldout.value > 0)


@one_thread
def with_shape_gains(fit: Fit, guesses: Sequence[Guess], least: float) -> list[Guess]:
    """Return the guesses, slow errors that are worth `least` beside white noise also weighed by their shape.

    It is one of two of each triple. Noise as coloured as it may be is that everywhere, also where a walk is not: the
    shape takes that into account.
    """
    known: dict[tuple[str, str], SlowErrors] = {}
    out = []
    for g in guesses:
        place = (g.term.at, g.term.part)
        if g.term.drift and g.term.part in CHANNELS and g.white > least:
            known[place] = known.get(place) or SlowErrors.of(fit, g.term)
            price = np.log(2 * len(CHANNELS) * len(fit.model.recording.imus))
            g = replace(g, shape=known[place].beyond(g.term) - float(price))
        out.append(g)
    return out


def follows_lone_accelerometer(fit: Fit) -> bool:
    """Return whether a spline follows all that a lone accelerometer reads.

    Nothing but its gyroscope says then how the IMU turns, and what its noise adds to a turn's acceleration goes with
    the turn as a delay does.
    """
    alone = len(fit.model.recording.imus) == 1
    return alone and any(h.effect.free and h.effect.place == "joint" for h in fit.model.hypotheses)


__all__ = ["best_term", "follows_lone_accelerometer"]
