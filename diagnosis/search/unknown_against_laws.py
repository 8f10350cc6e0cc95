"""A series without a name, held against the laws whose series it may be: the filters and springs of its IMU.

To second order in its time a filter or a spring adds the slope and the bend of what goes in. A weak one leaves so
little that the search does not ask for it, or predicts too little, and the series is found instead. The motion follows
what is left out; with a law it has less freedom to follow noise there. So a law is judged by what it gains on left-out
data plus the freedoms that it spares.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.criteria.conditional_aic import aic_gain, aic_gain_and_freedoms
from imubench.diagnosis.criteria.cross_validation import heldout_gain
from imubench.diagnosis.criteria.dynamic_score import screen
from imubench.diagnosis.criteria.plausible_fit import holds_its_law
from imubench.diagnosis.criteria.trial import Gain, Kept, Trial
from imubench.diagnosis.discrepancy.terms import SERIES, Unknown
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.loop import Rule
from imubench.diagnosis.search.moves.dynamic_refits import refit_from_screening
from imubench.diagnosis.search.moves.move import Above, Holds, Proposal, Proposals, SearchState
from imubench.diagnosis.search.moves.term_rivals import NEARLY
from imubench.diagnosis.search.selected import DROP_NEEDLESS, Selection, candidates
from imubench.diagnosis.search.unnamed import Unknowns
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.refit import refit, refit_without
from imubench.progress import tell


@dataclass(frozen=True)
class LawForSeries:
    """The filter or the spring that is worth more than a series without a name at its IMU.

    Beside a pose whose errors wander a series belongs to the pose, and so would a law. Effects whose place the series
    took are left out at first, and come back to be weighed beside the law: part of a filter's delay may be a clock's
    offset.
    """

    term: Hypothesis  # the series
    gone: tuple[Hypothesis, ...]  # effects that something without a name took the place of

    def propose(self, state: SearchState) -> Proposals:
        """Yield the best law in the place of the series."""
        if len(state.kept) >= ADMISSION.most_effects:
            return
        tell(f"looking whether a law says what {self.term.name} is")
        gone = tuple(h for h in self.gone if h in state.fit.model.hypotheses)
        fit = with_noise(refit_without(state.fit, gone)) if gone else state.fit
        best = by_law(fit, self.term.at)
        if best is None:
            return

        won = cache(lambda: heldout_gain(fit, best.fit, np.random.default_rng(STATISTICS.seed)))

        def after(_: Gain | None) -> SearchState:
            new, now = Kept(best.hypothesis, best.evidence, won(), ()), best.fit
            back = tuple(h for h in gone if not h.effect.states)
            kept = [k for k in (*state.kept, new) if k.hypothesis not in gone or k.hypothesis in back]
            if back:
                return state.changed(with_noise(refit(now, (*now.model.hypotheses, *back))), kept)
            return replace(state.changed(now, kept), weighed=now)

        yield Proposal(
            f"{best.hypothesis.name} in the place of {self.term.name}",
            after,
            (
                Above(lambda: best.evidence, EVIDENCE.state_nat, reached=True),
                Above(lambda: won().low - aic_gain_and_freedoms(fit, best.fit)[1], 0.0),
                Holds(lambda: as_good(best, won(), fit, with_series(fit, self.term))),
            ),
        )


def laws_for_series(chosen: Selection, strange: Unknowns) -> list[Rule]:
    """Return the rules that hold each series without a name against laws, and then ask what is needed beside one."""
    gone = tuple(h for h in chosen.fit.model.hypotheses if h not in strange.fit.model.hypotheses)
    if chosen.fit.model.wander:
        return []
    terms = [
        h for h in strange.fit.model.hypotheses if isinstance(h.effect, Unknown) and h.effect.term.goes_with in SERIES
    ]
    return [rule for h in terms for rule in (Rule("law-for-series", LawForSeries(h, gone)), DROP_NEEDLESS)]


def as_good(best: Trial, won: Gain, fit: Fit, series: Fit) -> bool:
    """Return whether a law is worth more than a series, or nearly as much and gains more on left-out data.

    The states of a law follow some noise, and pay for it.
    """
    other = aic_gain(fit, series)
    if best.evidence >= other:
        return True
    return (
        best.evidence * (1 + NEARLY) > other
        and won.value > heldout_gain(fit, series, np.random.default_rng(STATISTICS.seed)).value
    )


def by_law(fit: Fit, at: str) -> Trial | None:
    """Return the best refit with an effect of an IMU whose states obey a law; none where it has one already."""
    if any(h.at == at and h.effect.states for h in fit.model.hypotheses):
        return None
    asked = [h for h in candidates(fit.model) if h.at == at and h.effect.states and h.effect.lawful]
    trials = []
    for some in screen(fit, [h for h in asked if h.effect.variant != "isotropic"])[: ADMISSION.refits]:
        with suppress(NotPositiveDefiniteError):
            trials.append(refit_from_screening(fit, [some], rounds=REML.last_rounds))
    return max((t for t in trials if holds_its_law(t) and rings(t)), key=lambda t: t.evidence, default=None)


def rings(trial: Trial) -> bool:
    """Return whether samples show springs swing, on an axis at least: what gives way without is the series itself.

    Springs swing too fast to be seen above half the sampling rate.
    """
    h, fit = trial.hypothesis, trial.fit
    swing = [np.exp(fit.state.values[h.key(p.name)]).min() for p in h.effect.parameters if p.unit == "Hz"]
    return h.effect.filters or all(f < fit.model.recording.imu(h.at).rate / 2 for f in swing)


def with_series(fit: Fit, term: Hypothesis) -> Fit:
    """Return the fit with a series more, at the noise that it leaves."""
    return with_noise(refit(fit, (*fit.model.hypotheses, term), steps=4), 2)


__all__ = ["LawForSeries", "laws_for_series"]
