"""Effects without states: their scores beside a fit, and exact refits of the best."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from imubench.diagnosis.candidates.grids import placed_at_best_start
from imubench.diagnosis.candidates.mount_start import better_start
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.plausible_fit import natural
from imubench.diagnosis.criteria.score_test import Score, score
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.refit import log_evidence, refit
from imubench.diagnosis.solve.schur import Base
from imubench.diagnosis.solve.threads import side_by_side
from imubench.effects.effect import Effect

NEAR = 0.1  # of the best promise: a score below is not worth a refit
MARGIN_S = 0.5  # s of recording on either side of a moment: what was so all along has none
HALF = 0.5  # of the best's evidence, from which a clock's error is refitted too


def plain_scores(fit: Fit, left: list[Hypothesis]) -> tuple[list[Hypothesis], list[Score]]:
    """Return the effects without states at their best starts, and what they promise, best first."""
    base = Base.of(fit)
    plain, judged = placed_at_best_start(base, [h for h in left if not h.effect.states])
    return plain, sorted([*score(fit, plain, base), *judged], key=lambda s: -s.evidence)


def plain_trials(
    fit: Fit, scores: list[Score], say: Callable[[str], None], most: int = ADMISSION.refits
) -> list[Trial]:
    """Return exact refits of the best scores, at most `most` of them, best evidence first; and of clocks half as good.

    A score is linear in a clock's error, and so promises too little of a large one.
    """
    best = max((s.evidence for s in scores), default=0.0)
    likely = [s for s in scores if s.evidence > max(EVIDENCE.needed_nat, NEAR * best)]
    chosen = [*likely[:most], *(s for s in likely[most:] if of_a_clock(s.hypothesis) and s.evidence > HALF * best)]
    base = log_evidence(fit)

    def tried(s: Score) -> Trial | None:
        say(f"refitting with {s.hypothesis.name}")
        done = better_start(fit, s.hypothesis, refit(fit, (*fit.model.hypotheses, s.hypothesis)))
        if not (dated(done, s.hypothesis) and natural(done, s.hypothesis)):
            return None
        return Trial(s.hypothesis, done, log_evidence(done) - base)

    out = [t for t in side_by_side(tried, chosen, fit.model.tracks.knots.count) if t is not None]
    return heard_first(sorted(out, key=lambda t: -t.evidence), fit.model.humming)


def heard_first(trials: list[Trial], humming: Collection[str]) -> list[Trial]:
    """Return trials, a hum at an IMU whose raw samples hum before one elsewhere that is worth as much.

    A free motion carries a hum from one IMU to the other, so the likelihood alone cannot tell them apart.
    """
    if not trials or not trials[0].hypothesis.effect.tone or trials[0].hypothesis.at in humming:
        return trials
    least = trials[0].evidence - EVIDENCE.needed_nat

    def heard(t: Trial) -> bool:
        return bool(t.hypothesis.effect.tone) and t.hypothesis.at in humming and t.evidence > least

    return sorted(trials, key=heard, reverse=True)


def next_plain(fit: Fit, plain: Sequence[Hypothesis], say: Callable[[str], None]) -> Trial | None:
    """Return the best of effects at their starts that are not in a fit, at the noise it leaves, or None."""
    names = {h.name for h in fit.model.hypotheses}
    tried = plain_trials(fit, score(fit, [h for h in plain if h.name not in names]), say, 1)
    return (
        replace(tried[0], fit=with_noise(tried[0].fit)) if tried and tried[0].evidence >= EVIDENCE.needed_nat else None
    )


def of_a_clock(h: Hypothesis) -> bool:
    """Return whether an effect is one of a sensor's clock."""
    return type(h.effect).clock is not Effect.clock


def dated(fit: Fit, h: Hypothesis) -> bool:
    """Return whether an effect's moment, where it has one, has recording before and after it."""
    start, end = fit.span
    moments = [fit.state.values[h.key(p.name)] for p in h.effect.parameters if p.name == "time"]
    return all(bool(np.all((t > start + MARGIN_S) & (t < end - MARGIN_S))) for t in moments)


__all__ = ["heard_first", "next_plain", "plain_scores", "plain_trials"]
