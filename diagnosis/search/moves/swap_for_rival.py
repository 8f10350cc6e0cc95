"""A rival that was as good when it was passed over may be the better one beside what came later.

An effect of many numbers may also do what two of few do, before the second of these has come in: a g-sensitivity the
work of a bias and its drift. So it is held against both.
"""

from collections.abc import Callable, Sequence

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.trial import Kept, Passed
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.add import plain_scores, plain_trials
from imubench.diagnosis.search.moves.move import Above, Proposal, Proposals, SearchState
from imubench.diagnosis.solve.refit import log_evidence, refit
from imubench.progress import tell


class RivalForEffect:
    """The rival of an effect's round in its place, where it is now worth more."""

    def propose(self, state: SearchState) -> Proposals:
        """Yield the best near rival of every effect; it must be worth more than the best beside the effect, too.

        Beside it: one of everything that may come in, with no more numbers together.
        """
        for k in state.kept if len(state.kept) > 1 else ():
            near = [t for t in k.rivals if t.evidence > k.near]
            for t in [t for t in near if t.hypothesis.name not in state.names and not t.hypothesis.effect.states][:1]:
                tell(f"trying {t.hypothesis.name} in the place of {k.hypothesis.name}")
                state = (yield instead(state, k, t.hypothesis)).state


def instead(state: SearchState, old: Kept, h: Hypothesis) -> Proposal:
    """Return the proposal of another effect in the place of one."""
    fit = state.fit
    tried = refit(fit, tuple(h if o == old.hypothesis else o for o in fit.model.hypotheses))
    more = log_evidence(tried) - log_evidence(fit)
    further = h.effect.numbers - old.hypothesis.effect.numbers
    new = Kept(h, old.evidence, old.heldout, (Passed(old.hypothesis, old.evidence - EVIDENCE.needed_nat),))
    kept = [new if other is old else other for other in state.kept]
    return Proposal(
        f"{h.name} in the place of {old.hypothesis.name}",
        lambda _: state.changed(with_noise(tried), kept),
        (
            Above(lambda: more, EVIDENCE.needed_nat),
            Above(lambda: more - beside(fit, further, state.everything, tell), 0.0),
        ),
    )


def beside(fit: Fit, most: int, everything: Sequence[Hypothesis], say: Callable[[str], None]) -> float:
    """Return the nat that the best effect without states is worth beside a fit's, of at most so many numbers."""
    taken = {h.name for h in fit.model.hypotheses}
    few = [h for h in everything if h.name not in taken and 0 < h.effect.numbers <= most]
    tried = plain_trials(fit, plain_scores(fit, few)[1], say, 1) if few else []
    return tried[0].evidence if tried else 0.0
