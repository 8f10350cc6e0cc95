"""Something without a name, held against effects of its IMU as small as it is.

The search prices an effect's numbers by how large they may be, so an effect of many numbers that are far smaller may
cost more than it explains. A term's weights are as large as they explain most, and the term is found instead. So each
effect gets such a size as well (`own_size`). Which of all effects it is costs the logarithm of their number. One that
comes near the term without taking its place is what it may be all the same, as far as the recording tells: its equal.
"""

from dataclasses import dataclass, replace

import numpy as np

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.criteria.cross_validation import heldout_gain
from imubench.diagnosis.criteria.score_at_size import scores_at_size
from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.discrepancy.terms import Unknown
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.result import UNKNOWN, Rejected
from imubench.diagnosis.search.loop import Rule
from imubench.diagnosis.search.moves.move import Foretells, Proposal, Proposals, SearchState, told
from imubench.diagnosis.search.selected import DROP_NEEDLESS, Selection, candidates
from imubench.diagnosis.search.unnamed import Unknowns
from imubench.diagnosis.solve.refit import refit, refit_without
from imubench.diagnosis.solve.schur import Base
from imubench.progress import tell


@dataclass(frozen=True)
class EffectForTerm:
    """The effect that explains as much as something without a name at its IMU, as small as it is.

    It may be what another one stood for, which then goes: an accelerometer's scale came in at the other IMU while a
    filter was at the wrong one, and there it was nothing beside the scale that a term was.
    """

    term: Hypothesis

    def propose(self, state: SearchState) -> Proposals:
        """Yield the best effect that is nearly straight in its numbers."""
        if len(state.kept) == ADMISSION.most_effects:
            return
        tell(f"looking whether an effect is as small as {self.term.name}")
        fit, every = state.fit, candidates(state.fit.model)
        likely = [h for h in every if h.at == self.term.at and nearly_straight(h) and h.name not in state.names]
        nat = scores_at_size(Base.of(fit), [self.term, *likely])
        best = max(likely, key=lambda h: nat[h], default=self.term)
        worth, size = nat[best]
        if best is self.term or worth < max(nat[self.term][0], EVIDENCE.needed_nat + np.log(len(every))):
            return
        small = replace(best, effect=best.effect.as_large(size))
        better = with_noise(refit(fit, (*fit.model.hypotheses, small)))
        yield Proposal(
            f"{best.name} in the place of {self.term.name}",
            lambda won: state.changed(better, [*state.kept, Kept(small, worth, told(won), ())]),
            (Foretells(lambda: heldout_gain(fit, better, np.random.default_rng(STATISTICS.seed))),),
        )


def effects_for_terms(_: Selection, strange: Unknowns) -> list[Rule]:
    """Return the rules that hold each thing without a name against effects, and then ask what is needed beside one."""
    terms = [h for h in strange.fit.model.hypotheses if isinstance(h.effect, Unknown)]
    return [rule for h in terms for rule in (Rule("effect-for-term", EffectForTerm(h)), DROP_NEEDLESS)]


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


__all__ = ["EffectForTerm", "effects_for_terms", "with_equals"]
