"""A series without a name, held against the laws whose series it may be: the filters and springs of its IMU.

To second order in its time a filter or a spring adds the slope and the bend of what goes in. A weak one leaves so
little that the search does not ask for it, or predicts too little, and the series is found instead. What is left out is
followed by the motion, and a law leaves the motion less freedom to follow noise there: it is asked for what it gains on
left-out data and those freedoms (a mount of 12 Hz that was worth 404 nat, a series 96, lost 49 and spared 644).
"""

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from imubench.diagnosis.config.criteria import ADMISSION, HELD_OUT
from imubench.diagnosis.criteria.conditional_aic import aic_gain, aic_gain_and_freedoms
from imubench.diagnosis.criteria.cross_validation import Gain, heldout_gain
from imubench.diagnosis.criteria.dynamic_aic import holds_its_law
from imubench.diagnosis.criteria.dynamic_score import screen
from imubench.diagnosis.criteria.trial import Kept, Trial
from imubench.diagnosis.discrepancy.terms import SERIES, Unknown
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.admission import Refused
from imubench.diagnosis.search.moves.add_dynamic import MORE
from imubench.diagnosis.search.moves.drop import SPLINES, prune
from imubench.diagnosis.search.moves.dynamic_refits import ROUNDS, refit_from_screening
from imubench.diagnosis.search.moves.term_rivals import NEARLY
from imubench.diagnosis.search.selection import Selection, candidates
from imubench.diagnosis.search.unknown import Unknowns
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.levenberg_marquardt import Fit
from imubench.diagnosis.solve.refit import refit, refit_without
from imubench.diagnosis.traits import FILTER


def named_by_law(selection: Selection, strange: Unknowns, say: Callable[[str], None] = lambda _: None) -> Selection:
    """Return the selection, with the filter or the spring that is worth more than a series of `strange`, if one is.

    Beside a pose whose errors wander a series is theirs, and so would be a law's (a filter of 825 nat, and no offset).
    What the series took the place of is not in the way, and comes back where it is worth something beside the law: of a
    gyroscope's filter of 0.34 ms half was a clock's offset.
    """
    gone = [h for h in selection.fit.model.hypotheses if h not in strange.fit.model.hypotheses]
    back = [h for h in gone if not h.effect.states]
    for term in strange.fit.model.hypotheses if not selection.fit.model.wander else ():
        if (
            isinstance(term.effect, Unknown)
            and term.effect.term.goes_with in SERIES
            and len(selection.kept) < ADMISSION.most_effects
        ):
            say(f"looking whether a law says what {term.name} is")
            fit = with_noise(refit_without(selection.fit, gone)) if gone else selection.fit
            best = by_law(fit, term.at)
            if best is None or best.evidence < SPLINES:
                continue
            won = heldout_gain(fit, best.fit, np.random.default_rng(HELD_OUT.bootstrap_seed))
            if won.low > aic_gain_and_freedoms(fit, best.fit)[1] and as_good(best, won, fit, with_series(fit, term)):
                new, now = Kept(best.hypothesis, best.evidence, won, ()), best.fit
                dropped: Refused = []
                kept = [k for k in (*selection.kept, new) if k.hypothesis not in gone or k.hypothesis in back]
                if back:
                    now, kept, dropped = prune(with_noise(refit(now, (*now.model.hypotheses, *back))), kept, say)
                selection = Selection(now, tuple(kept), (*selection.rejected, *dropped))
    return selection


def as_good(best: Trial, won: Gain, fit: Fit, series: Fit) -> bool:
    """Return whether a law is worth more than a series, or nearly as much and gains more on left-out data.

    Its states follow some noise, and pay for it: a filter was worth 185 nat for 212, and gained 235 for 215.
    """
    other = aic_gain(fit, series)
    if best.evidence >= other:
        return True
    return (
        best.evidence * (1 + NEARLY) > other
        and won.value > heldout_gain(fit, series, np.random.default_rng(HELD_OUT.bootstrap_seed)).value
    )


def by_law(fit: Fit, at: str) -> Trial | None:
    """Return the best refit with an effect of an IMU whose states obey a law; none where it has one already."""
    if any(h.at == at and h.effect.states for h in fit.model.hypotheses):
        return None
    asked = [h for h in candidates(fit.model) if h.at == at and h.effect.states and h.effect.lawful]
    trials = []
    for some in screen(fit, [h for h in asked if h.effect.variant != "isotropic"])[: ADMISSION.refits]:
        with suppress(NotPositiveDefiniteError):
            trials.append(refit_from_screening(fit, [some], rounds=ROUNDS + MORE))
    return max((t for t in trials if holds_its_law(t) and rings(t)), key=lambda t: t.evidence, default=None)


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
