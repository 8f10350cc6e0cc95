"""Two effects that are one: each took a part of what a third explains alone.

The search adds one effect after the other, and what explains most alone may be a part of what is there: a hinge axis
that turns with the angle, then a centre that moves with it, and together they are an IMU that slides with its skin.
"""

from contextlib import suppress
from itertools import combinations

from imubench.diagnosis.config.criteria import EQUIVALENCE
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.equivalence import Replacement, alternatives, replacements
from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.search.moves.move import Above, Proposal, Proposals, SearchState
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.refit import evidence_over, refit
from imubench.progress import tell

PRICE = EVIDENCE.needed_nat + EVIDENCE.needed_nat  # nat: what a second name must be worth, beyond what counts as a tie


class Merge:
    """One effect in the place of two without states, where a second one is not worth its price.

    The new one comes without evidence or held-out gain of its own, as what is in a model from the start.
    """

    def propose(self, state: SearchState) -> Proposals:
        """Yield the best single effect for each pair; once one is taken, for each pair of what is then there."""
        fit = state.fit
        for pair in combinations([k for k in state.kept if k.hypothesis in fit.model.hypotheses], 2):
            two = [k.hypothesis for k in pair]
            if any(h.effect.states for h in two):
                continue
            for one in replacements(fit, two, alternatives(fit.model, two[0]))[:1]:
                rub = all(h.effect.friction for h in (*two, one.hypothesis))  # settled, in a smoother motion
                if one.share < EQUIVALENCE.doubt and not rub and (proposal := instead(state, pair, one)) is not None:
                    answer = yield proposal
                    if answer.accepted:
                        yield from self.propose(answer.state)
                        return


def instead(state: SearchState, pair: tuple[Kept, Kept], one: Replacement) -> Proposal | None:
    """Return the proposal of one effect in the place of two; None where it cannot be fitted."""
    fit, gone = state.fit, [k.hypothesis for k in pair]
    what = f"{one.hypothesis.name} in the place of {' and '.join(h.name for h in gone)}"
    tell(f"trying {what}")
    rest = tuple(h for h in fit.model.hypotheses if h not in gone)
    with suppress(NotPositiveDefiniteError):
        tried = refit(fit, (*rest, one.hypothesis), one.guess)
        kept = [*(k for k in state.kept if k not in pair), Kept.unjudged(one.hypothesis)]
        return Proposal(
            what,
            lambda _: state.changed(with_noise(tried), kept),
            (Above(lambda: evidence_over(fit, tried), -PRICE),),
        )
    return None


__all__ = ["Merge"]
