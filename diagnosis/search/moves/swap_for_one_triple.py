"""A filter of both triples whose law holds for one of them alone: of the other it was something else.

A filter's readings are states, which take in whatever else is wrong with a triple as far as its law lets them. Of a
gyroscope's filter of 14 Hz beside an accelerometer's scale the best was one of both, which broke its law by 2.5 times
its standard deviation at the accelerometer and held it at the gyroscope. The gyroscope's alone was worth 2,154 nat
less, and with the scale 111 more.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.cross_validation import heldout_gain
from imubench.diagnosis.criteria.dynamic_aic import TRIPLES
from imubench.diagnosis.criteria.trial import Kept, Passed
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.add import plain_scores, plain_trials
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.levenberg_marquardt import Fit
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.traits import FILTER

BROKEN = 1.0  # of a law's std, above which the law does not hold


def filter_to_one_triple(
    fit: Fit,
    kept: list[Kept],
    everything: Sequence[Hypothesis],
    rng: np.random.Generator,
    say: Callable[[str], None],
) -> tuple[Fit, list[Kept]]:
    """Return the fit and its effects, a filter changed for one of a triple alone and the best without states beside it.

    Where these two together predict the samples better. `everything` is what could come in.
    """
    for k in [k for k in kept if k.hypothesis.effect.name == FILTER and len(kept) < ADMISSION.most_effects]:
        half = of_one(fit, k.hypothesis, everything)
        if half is None:
            continue
        say(f"trying {half.name} and more in the place of {k.hypothesis.name}")
        rest = tuple(h for h in fit.model.hypotheses if h != k.hypothesis)
        with suppress(NotPositiveDefiniteError):
            begun = {half.key("cutoff"): fit.state.values[k.hypothesis.key("cutoff")]}
            alone = with_noise(refit(fit, (*rest, half), begun))
            left = [h for h in everything if h.name not in {o.name for o in alone.model.hypotheses}]
            tried = plain_trials(alone, plain_scores(alone, left)[1], say, 1)
            if not tried or tried[0].evidence < EVIDENCE.needed_nat:
                continue
            both = with_noise(tried[0].fit)
            won = heldout_gain(alone, both, rng)
            if won.is_sure() and aic_gain(fit, both) > EVIDENCE.needed_nat:
                new = replace(k, hypothesis=half, rivals=(Passed(k.hypothesis, k.evidence), *k.rivals))
                kept = [new if other is k else other for other in kept]
                kept, fit = [*kept, Kept(tried[0].hypothesis, tried[0].evidence, won, ())], both
    return fit, kept


def of_one(fit: Fit, h: Hypothesis, everything: Sequence[Hypothesis]) -> Hypothesis | None:
    """Return the filter of the triple at which one of both keeps its law; None where it does at both or neither."""
    levels = {part: fit.noise.get(h.key(part)) for part in TRIPLES}
    held = [part for part, level in levels.items() if level is not None and level <= BROKEN]
    if len(held) != 1 or None in levels.values():
        return None
    return next((o for o in everything if (o.effect.name, o.effect.variant, o.at) == (FILTER, held[0], h.at)), None)


__all__ = ["filter_to_one_triple", "of_one"]
