"""A series without a name, held against the laws whose series it may be: the filters and springs of its IMU.

To second order in its time a filter or a spring adds the slope and the bend of what goes in. A weak one leaves so
little that the search does not ask for it, or predicts too little, and the series is found instead. What is left out is
followed by the motion, and a law leaves the motion less freedom to follow noise there: it is asked for what it gains on
left-out data and those freedoms (a mount of 12 Hz that was worth 404 nat, a series 96, lost 49 and spared 644).
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.diagnosis.blocks import NotPositiveDefiniteError
from imubench.diagnosis.entered import MOST, foretold
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.hypothesis import Hypothesis
from imubench.diagnosis.lively import MORE
from imubench.diagnosis.lively_fits import ROUNDS, begun_screened
from imubench.diagnosis.lively_worth import resolved
from imubench.diagnosis.noise import with_noise
from imubench.diagnosis.prune import SEED, SPLINES
from imubench.diagnosis.refit import refit
from imubench.diagnosis.screen import screen
from imubench.diagnosis.select import Selection, candidates
from imubench.diagnosis.terms import SERIES, Unknown
from imubench.diagnosis.trial import FILTER, TRIED, Kept, Trial
from imubench.diagnosis.unknown import Unknowns
from imubench.diagnosis.worth import weighed, worth


def named_by_law(selection: Selection, strange: Unknowns, say: Callable[[str], None] = lambda _: None) -> Selection:
    """Return the selection, with the filter or the spring that is worth more than a series of `strange`, if one is.

    Beside a pose whose errors wander a series is theirs, and so would be a law's (a filter of 825 nat, and no offset).
    """
    for term in strange.fit.model.hypotheses if not selection.fit.model.wander else ():
        if isinstance(term.effect, Unknown) and term.effect.term.goes_with in SERIES and len(selection.kept) < MOST:
            say(f"looking whether a law says what {term.name} is")
            best = by_law(selection.fit, term.at)
            if best is None or best.evidence < max(SPLINES, worth(selection.fit, with_series(selection.fit, term))):
                continue
            won = foretold(selection.fit, best.fit, np.random.default_rng(SEED))
            if won.low > weighed(selection.fit, best.fit)[1]:
                kept = Kept(best.hypothesis, best.evidence, won, ())
                selection = replace(selection, fit=best.fit, kept=(*selection.kept, kept))
    return selection


def by_law(fit: Fit, at: str) -> Trial | None:
    """Return the best refit with an effect of an IMU whose states obey a law; none where it has one already."""
    if any(h.at == at and h.effect.states for h in fit.model.hypotheses):
        return None
    asked = [h for h in candidates(fit.model) if h.at == at and h.effect.states and h.effect.lawful]
    trials = []
    for some in screen(fit, [h for h in asked if h.effect.variant != "isotropic"])[:TRIED]:
        with suppress(NotPositiveDefiniteError):
            trials.append(begun_screened(fit, [some], rounds=ROUNDS + MORE))
    return max((t for t in trials if resolved(t) and rings(t)), key=lambda t: t.evidence, default=None)


def rings(trial: Trial) -> bool:
    """Return whether samples show springs swing, on an axis at least: what gives way without is the series itself.

    A real IMU, screwed on, had springs of 24, 46 and 92 Hz at 40 samples a second.
    """
    h, fit = trial.hypothesis, trial.fit
    swing = [np.exp(fit.state.values[h.key(p.name)]).min() for p in h.effect.parameters if p.unit == "Hz"]
    return h.effect.name == FILTER or all(f < fit.model.recording.imu(h.at).rate / 2 for f in swing)


def with_series(fit: Fit, term: Hypothesis) -> Fit:
    """Return the fit with a series more, at the noise that it leaves."""
    return with_noise(refit(fit, (*fit.model.hypotheses, term), steps=4), 2)


__all__ = ["named_by_law"]
