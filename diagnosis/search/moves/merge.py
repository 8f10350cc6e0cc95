"""Two effects that are one: each took a part of what a third explains alone.

The search adds one effect after the other, and what explains most alone may be a part of what is there: a hinge axis
that turns with the angle, then a centre that moves with it, and together they are an IMU that slides with its skin.
"""

from collections.abc import Callable
from contextlib import suppress
from itertools import combinations

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.equivalence import Replacement, alternatives, replacements
from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.levenberg_marquardt import Fit
from imubench.diagnosis.solve.refit import evidence_over, refit
from imubench.diagnosis.traits import FRICTION

SHARE = 0.2  # of what two explain, that one in their place is expected to lose at most: laws are not linear
PRICE = EVIDENCE.needed_nat + EVIDENCE.needed_nat  # nat: what a second name must be worth, beyond what counts as a tie


def merged(fit: Fit, kept: list[Kept], say: Callable[[str], None]) -> tuple[Fit, list[Kept]]:
    """Return the fit and its effects, two without states changed for one beside which a second is not worth its price.

    The new one comes without evidence or held-out gain of its own, as what is in a model from the start.
    """
    plain = [k for k in kept if k.hypothesis in fit.model.hypotheses and not k.hypothesis.effect.states]
    for pair in combinations(plain, 2):
        two = [k.hypothesis for k in pair]
        for one in replacements(fit, two, alternatives(fit.model, two[0]))[:1]:
            rub = all(h.effect.name in FRICTION for h in (*two, one.hypothesis))  # settled, in a smoother motion
            if one.share < SHARE and not rub:
                say(f"trying {one.hypothesis.name} in the place of {' and '.join(h.name for h in two)}")
                better = _instead(fit, pair, one)
                if better is not None:
                    rest = [k for k in kept if k not in pair]
                    return merged(better, [*rest, Kept.unjudged(one.hypothesis)], say)
    return fit, kept


def _instead(fit: Fit, pair: tuple[Kept, Kept], one: Replacement) -> Fit | None:
    """Return the fit with one effect in the place of two, at the noise that it leaves; None where that is worse."""
    gone = {k.hypothesis for k in pair}
    rest = tuple(h for h in fit.model.hypotheses if h not in gone)
    with suppress(NotPositiveDefiniteError):
        tried = refit(fit, (*rest, one.hypothesis), one.guess)
        if evidence_over(fit, tried) > -PRICE:
            return with_noise(tried)
    return None


__all__ = ["merged"]
