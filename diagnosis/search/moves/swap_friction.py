"""Which laws of friction a swing needs: every mixture of them is weighed, for one law stands in for two others.

While a swing dies down slowly, friction of one size and drag together take as much from every swing as friction that
grows with the rate. Named one after the other the middle one comes first, and neither of the two replaces it alone.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import combinations

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.criteria.cross_validation import predicted
from imubench.diagnosis.criteria.plausible_fit import natural
from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.noise.looser_motion import at_estimated_roughness
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.drop import about_zero
from imubench.diagnosis.search.moves.move import Above, Holds, Proposal, Proposals, SearchState
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.refit import evidence_over, information, refit, refit_without
from imubench.effects import EFFECTS
from imubench.progress import tell


class FrictionMixture:
    """Those laws of friction that together have the most evidence, in the place of those in the fit.

    They are told apart where the motion is no rougher than it was estimated to be: the equation of motion says how it
    goes on, and in a loose motion it counts for little. The loose one, which is what is known of hands, may not object.
    New ones come without evidence or held-out gain of their own, as what is in a model from the start.
    """

    def propose(self, state: SearchState) -> Proposals:
        """Yield the best mixture, if it is another."""
        fit = state.fit
        now = [h for h in fit.model.hypotheses if h.effect.friction]
        if not now:
            return
        tell("weighing every mixture of the laws of friction")
        rest = tuple(h for h in fit.model.hypotheses if h not in now)
        named = {h.effect.name for h in now}
        others = (Hypothesis(e, "joint") for e in EFFECTS.values() if e.friction and e.name not in named)
        laws = [*now, *others]
        with suppress(NotPositiveDefiniteError):
            whole = with_noise(refit(at_estimated_roughness(fit), (*rest, *laws)), REML.rounds)
            best = mixture(whole, laws)
            if not best or set(best) == set(now):
                return
            tried = refit(fit, (*rest, *best))
            smooth = [refit(whole, (*rest, *some), steps=4) for some in (now, best)]
            stay = [k for k in state.kept if k.hypothesis not in now or k.hypothesis in best]
            new = [Kept.unjudged(h) for h in best if h not in now]
            yield Proposal(
                f"{' and '.join(h.name for h in best)} in the place of {' and '.join(h.name for h in now)}",
                lambda _: state.changed(with_noise(tried), [*stay, *new]),
                (
                    Above(lambda: evidence_over(fit, tried), -EVIDENCE.needed_nat),
                    Above(lambda: evidence_over(*smooth), EVIDENCE.needed_nat),
                    Holds(lambda: all(natural(tried, h) for h in best)),
                ),
            )


def together(fit: Fit, kept: Sequence[Kept]) -> Sequence[Kept]:
    """Return the effects with what all laws of friction gain on held-out data, where there are several, for each.

    Each is worth little beside another, and a term of a tenth of that is no reason to doubt that there is friction.
    """
    rubbing = [k for k in kept if k.hypothesis.effect.friction]
    if len(rubbing) < 2:
        return kept
    gone = {k.hypothesis for k in rubbing}
    bare = refit_without(fit, gone, steps=4)
    won = predicted(bare, fit, np.random.default_rng(STATISTICS.seed))
    return [replace(k, heldout=won) if k in rubbing else k for k in kept]


def mixture(whole: Fit, laws: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Return those of a fit's laws of friction that the others add nothing to; none of them drives.

    By the Gaussian about the fit with all of them: they are linear in their sizes.
    """
    covariance, _ = information(whole)
    found: list[tuple[float, tuple[Hypothesis, ...]]] = []
    for count in range(1, len(laws) + 1):
        for some in combinations(laws, count):
            gone = [h for h in laws if h not in some]
            if np.all(without(whole, some, gone, covariance) >= 0.0):
                found.append((about_zero(whole, gone, covariance) if gone else 0.0, some))
    return min(found, key=lambda f: f[0], default=(0.0, ()))[1]


def without(whole: Fit, some: Sequence[Hypothesis], gone: Sequence[Hypothesis], covariance: Array) -> Array:
    """Return the sizes (k,) of some laws where others are zero, by the Gaussian about a fit with all."""
    keys, others = ([h.key(p.name) for h in laws for p in h.effect.parameters] for laws in (some, gone))
    value = np.concatenate([whole.state.values[name] for name in keys])
    if not others:
        return value
    own, zero = (whole.model.parameters.places(names) for names in (keys, others))
    off = np.concatenate([whole.state.values[name] for name in others])
    return np.asarray(value - covariance[np.ix_(own, zero)] @ np.linalg.solve(covariance[np.ix_(zero, zero)], off))


__all__ = ["FrictionMixture", "mixture", "together"]
