"""What a selection is: the effects that were found, and the fit with them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from imubench.diagnosis.candidates.both_mounts import gives_way
from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.noise.debiased_fit import debiased
from imubench.diagnosis.noise.looser_motion import with_looser_motion
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.rules import RuleUse
from imubench.diagnosis.search.loop import Repeat, Rule, Search
from imubench.diagnosis.search.moves.drop import Drop, changed
from imubench.diagnosis.search.moves.move import SearchState
from imubench.effects import possible


@dataclass(frozen=True)
class Selection:
    """What was found, and the fit with it."""

    fit: Fit
    kept: tuple[Kept, ...]
    rejected: tuple[tuple[Hypothesis, float], ...]  # nat on held-out data, or of evidence where that was enough
    not_tried: tuple[str, ...] = ()  # stages of the search that the time limit did not allow

    @cached_property
    def numbers(self) -> Fit:
        """The fit that the numbers are read off; where springs predict best, and not where they cost least."""
        return self.fit if gives_way(self.fit) else debiased(with_looser_motion(self.fit))

    def on_with(self, rules: Sequence[Rule | Repeat], use: RuleUse) -> "Selection":
        """Return what is found once some more rules were asked.

        Raises:
            OutOfTime: where the time limit stops them.
        """
        begun = SearchState(self.fit, self.kept, refused=self.rejected, weighed=self.fit, use=use)
        under_way = Search(begun)
        under_way.apply(rules)
        found = under_way.state
        if found is begun:
            return self
        return replace(self, fit=found.fit, kept=found.kept, rejected=(*found.refused, *found.dropped))

    @property
    def springs_refused(self) -> frozenset[str]:
        """Return the places at which springs explained much and foretold nothing."""
        return frozenset(h.at for h, _ in self.rejected if h.effect.on_springs)


def candidates(model: Model) -> list[Hypothesis]:
    """Return every effect at every place of a recording where it could act."""
    return [Hypothesis(effect, at) for effect, at in possible(model.recording) if effect.parameters or effect.states]


DROP_NEEDLESS = Rule("drop", Drop(), when=changed)
