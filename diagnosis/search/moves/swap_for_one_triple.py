"""A filter of both triples whose law holds for one of them alone: of the other it was something else.

A filter's readings are states, which take in whatever else is wrong with a triple as far as its law lets them. Where
the law holds for one triple and is broken at the other, a filter of the first alone is worth less, but more together
with the plain effect that the second one has.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.cross_validation import heldout_gain
from imubench.diagnosis.criteria.plausible_fit import TRIPLES
from imubench.diagnosis.criteria.trial import Kept, Passed, Trial
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.add import plain_scores, plain_trials
from imubench.diagnosis.search.moves.move import Above, Foretells, Proposal, Proposals, SearchState, told
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.refit import refit
from imubench.progress import tell

MOST_LAW_STD = 1.0  # of a law's std, above which the law does not hold


class FilterOfOneTriple:
    """A filter of one triple and the best without states beside it, in the place of a filter of both."""

    def propose(self, state: SearchState) -> Proposals:
        """Yield both together, for each filter whose law holds at one triple alone."""
        for k in [k for k in state.kept if k.hypothesis.effect.filters and len(state.kept) < ADMISSION.most_effects]:
            fit, half = state.fit, of_one(state.fit, k.hypothesis, state.everything)
            if half is None:
                continue
            tell(f"trying {half.name} and more in the place of {k.hypothesis.name}")
            rest = tuple(h for h in fit.model.hypotheses if h != k.hypothesis)
            with suppress(NotPositiveDefiniteError):
                begun = {half.key("cutoff"): fit.state.values[k.hypothesis.key("cutoff")]}
                alone = with_noise(refit(fit, (*rest, half), begun))
                left = [h for h in state.everything if h.name not in {o.name for o in alone.model.hypotheses}]
                tried = plain_trials(alone, plain_scores(alone, left)[1], tell, 1)
                if tried:
                    new = replace(k, hypothesis=half, rivals=(Passed(k.hypothesis, k.evidence), *k.rivals))
                    state = (yield both_instead(state, k, new, alone, tried[0])).state


def both_instead(state: SearchState, old: Kept, new: Kept, alone: Fit, beside: Trial) -> Proposal:
    """Return the proposal of an effect and one beside it in the place of another; `alone` is the fit with the first."""
    both = beside.fit
    if beside.evidence >= EVIDENCE.needed_nat:
        both = with_noise(beside.fit)
    kept = [new if other is old else other for other in state.kept]
    return Proposal(
        f"{new.hypothesis.name} and {beside.hypothesis.name} in the place of {old.hypothesis.name}",
        lambda won: state.changed(both, [*kept, Kept(beside.hypothesis, beside.evidence, told(won), ())]),
        (
            Above(lambda: beside.evidence, EVIDENCE.needed_nat, reached=True),
            Foretells(lambda: heldout_gain(alone, both, state.random)),
            Above(lambda: aic_gain(state.fit, both), EVIDENCE.needed_nat),
        ),
    )


def of_one(fit: Fit, h: Hypothesis, everything: Sequence[Hypothesis]) -> Hypothesis | None:
    """Return the filter of the triple at which one of both keeps its law; None where it does at both or neither."""
    levels = {part: fit.noise.get(h.key(part)) for part in TRIPLES}
    held = [part for part, level in levels.items() if level is not None and level <= MOST_LAW_STD]
    if len(held) != 1 or None in levels.values():
        return None
    return next(
        (o for o in everything if (o.effect.name, o.effect.variant, o.at) == (h.effect.name, held[0], h.at)), None
    )


__all__ = ["FilterOfOneTriple", "of_one"]
