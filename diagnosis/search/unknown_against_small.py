"""Something without a name, held against effects of its IMU as small as it is.

The search prices an effect's numbers by how large they may be: six numbers of a misalignment that are a hundredth
of that cost 33 nat, and one that explained 32 was not asked for. A term's weights are as large as they explain most,
and the term was found. So each effect gets such a size as well (`own_size`). Which of all effects it is costs the
logarithm of their number. One that comes near the term without taking its place is what it may be all the same, as far
as the recording tells: its equal.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.criteria import ADMISSION, HELD_OUT
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.cross_validation import heldout_gain
from imubench.diagnosis.criteria.score_at_size import scores_at_size
from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.discrepancy.terms import Unknown
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.result import UNKNOWN, Rejected
from imubench.diagnosis.search.moves.drop import prune
from imubench.diagnosis.search.selection import Selection, candidates
from imubench.diagnosis.search.unknown import Unknowns
from imubench.diagnosis.solve.refit import refit, refit_without
from imubench.diagnosis.solve.schur import Base


def named_by_size(selection: Selection, strange: Unknowns, say: Callable[[str], None] = lambda _: None) -> Selection:
    """Return the selection, with the effect that explains as much as a term of `strange` at its IMU, if one does.

    It may be what another one stood for, which then goes: an accelerometer's scale came in at the other IMU while a
    filter was at the wrong one, and there it was nothing beside the scale that a term was.
    """
    terms = [h for h in strange.fit.model.hypotheses if isinstance(h.effect, Unknown)]
    for term in terms:
        if len(selection.kept) == ADMISSION.most_effects:
            break
        say(f"looking whether an effect is as small as {term.name}")
        fit = selection.fit
        every, taken = candidates(fit.model), {h.name for h in fit.model.hypotheses}
        likely = [h for h in every if h.at == term.at and nearly_straight(h) and h.name not in taken]
        nat = scores_at_size(Base.of(fit), [term, *likely])
        best = max(likely, key=lambda h: nat[h], default=term)
        if best is term or nat[best][0] < max(nat[term][0], EVIDENCE.needed_nat + np.log(len(every))):
            continue
        worth, size = nat[best]
        small = replace(best, effect=best.effect.as_large(size))
        better = with_noise(refit(fit, (*fit.model.hypotheses, small)))
        won = heldout_gain(fit, better, np.random.default_rng(HELD_OUT.bootstrap_seed))
        if won.is_sure():
            fit, kept, dropped = prune(better, [*selection.kept, Kept(small, worth, won, ())], say)
            selection = Selection(fit, tuple(kept), (*selection.rejected, *dropped))
    return selection


def with_equals(strange: Unknowns) -> Unknowns:
    """Return what has no name, each with the effects, anywhere, that explain as much within `EVIDENCE.needed_nat` at
    their size.
    """
    fit, found = strange.fit, list(strange.findings)
    taken = {h.name for h in fit.model.hypotheses}
    likely = [h for h in candidates(fit.model) if nearly_straight(h) and h.name not in taken]
    for term in [h for h in fit.model.hypotheses if isinstance(h.effect, Unknown)]:
        i = next((i for i, f in enumerate(found) if f.at == term.at and f.effect == UNKNOWN), None)
        if i is None:
            continue
        nat = scores_at_size(Base.of(refit_without(fit, [term], steps=4)), [term, *likely])
        near = sorted(
            (h for h in likely if nat[h][0] > max(nat[term][0] - EVIDENCE.needed_nat, EVIDENCE.needed_nat)),
            key=lambda h: -nat[h][0],
        )
        beyond = found[i].heldout_gain.value - nat[term][0]
        found[i] = found[i].equalled_by(Rejected(h.effect.name, h.at, nat[h][0] + beyond) for h in near)
    return replace(strange, findings=tuple(found))


def nearly_straight(h: Hypothesis) -> bool:
    """Return whether an effect's law is nearly straight in its numbers."""
    return not h.effect.states and not h.effect.grid(1.0) and all(p.unit != "Hz" for p in h.effect.parameters)


__all__ = ["named_by_size", "with_equals"]
