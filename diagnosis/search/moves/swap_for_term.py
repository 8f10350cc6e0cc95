"""Named effects that only stand in for something without a name: held against terms in their place."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from imubench.diagnosis.config.discrepancy import TERM
from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.cross_validation import heldout_gain
from imubench.diagnosis.criteria.equivalence import equivalents
from imubench.diagnosis.criteria.score_at_size import gain_at_size
from imubench.diagnosis.discrepancy.drift_tests import beyond_a_drift
from imubench.diagnosis.discrepancy.fitted_terms import fitted_term
from imubench.diagnosis.discrepancy.term_scores import FittedTerm, Guess, promising
from imubench.diagnosis.noise.declared_noise import breaks_its_law
from imubench.diagnosis.noise.looser_motion import rougher
from imubench.diagnosis.noise.nominal import certain_effects
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.term_rivals import (
    a_filter_is,
    comes_late,
    groups,
    is_a_drift,
    margins,
    nearly_a_filter,
    only_wanders,
    seen_at,
    takes_place,
    together,
    wanders,
)
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.refit import evidence_over, refit_without

NAMES = 60  # effects at their places: what a name was chosen from, as a term from its like


@dataclass(frozen=True)
class TermSwaps:
    """What terms did to the names of a fit."""

    terms: list[FittedTerm]
    fit: Fit  # with these in the place of the names that they explain more than
    doubted: tuple[Hypothesis, ...]  # names beside which a term explains as much, and not surely more
    # of such terms what mostly is there, and its equals
    likely: tuple[tuple[FittedTerm, tuple[Hypothesis, ...]], ...] = ()


def swapped_for_terms(fit: Fit, say: Callable[[str], None] = lambda _: None) -> TermSwaps:
    """Return terms that explain more than named effects, the fit with them instead, and the names that they equal.

    What goes with shaking has a mean, and reads as a bias until it is held against one. A series holds a filter: it
    must explain much more, or a tenth more and gain more on left-out data, where a filter pays for no noise that its
    states follow. What else explains more than a filter is not its like. A few weights that explain as much as
    a spline without a law are the simpler answer: of them a tie is enough, of one that breaks its law a hundredth less,
    and of a slow curve a fifth, where a joint's play never comes back or a pivot is pushed one way for seconds.
    """
    terms: list[FittedTerm] = []
    doubted: list[Hypothesis] = []
    likelier: list[tuple[FittedTerm, tuple[Hypothesis, ...]]] = []
    for names in groups([h for h in fit.model.judged if h.effect.name not in certain_effects(fit.model)]):
        if len(terms) == TERM.most_terms or not set(names) <= set(fit.model.hypotheses):
            continue
        slow = only_wanders(fit, names[0])
        on_average = (h for h in fit.model.hypotheses if slow and (h.effect.misplaces or h.effect.onset))
        gone = (*names, *on_average)
        say(f"looking whether something without a name explains more than {' and '.join(h.name for h in gone)}")
        with suppress(NotPositiveDefiniteError):
            without = refit_without(fit, gone, steps=4)
            over = aic_gain if any(h.effect.states for h in gone) else evidence_over
            lost = over(without, fit)
            if terms and lost < 0:  # what came in for another name explains this one's part too
                fit = with_noise(without)
                continue
            guesses, tried = promising(without)
            price = float(np.log(max(tried / NAMES, 1)))
            won: list[tuple[bool, float, FittedTerm]] = []
            free = any(h.effect.free for h in names)
            strained = together(names) and breaks_its_law(fit, names[0])
            least = {timed: margins(lost, slow and timed, free, strained, len(gone)) for timed in (False, True)}
            likely = [g for g in guesses if g.white > least[g.term.timed][0]]
            likely = [g for g in likely if not g.term.holds(gone[0].effect.name)]
            asked = list(rivals(likely, fit, gone, slow))
            freer = rougher(fit) if asked else fit
            for guess in asked:
                done = fitted_term(without, guess, price)
                more = min(over(fit, done.fit), over(freer, done.freer)) / done.louder - price
                if guess.term.drift and is_a_drift(gone):
                    more = max(more, beyond_a_drift(without, guess.term))
                if done.heldout.is_sure() and more > -least[guess.term.timed][1]:
                    taken = takes_place(done, more, lost, names, free, strained)
                    if taken and nearly_a_filter(done, more, lost, gone):
                        taken = (
                            heldout_gain(without, fit, np.random.default_rng(STATISTICS.seed)).value
                            < done.heldout.value
                        )
                    won.append((taken, more, done))
            taken, more, best = max(won, key=lambda w: w[:2], default=(False, 0.0, None))
            if taken and best:
                surely = free or strained
                equal = () if surely or more > EVIDENCE.needed_nat + gain_at_size(without, gone, lost) else tuple(gone)
                terms, fit = [*terms, best if surely else replace(best, evidence=more, equal=equal)], best.fit
            elif (best and not a_filter_is(best, gone[0])) or wanders(guesses, gone, lost):
                doubted += gone
                likelier += [(best, gone)] if best and comes_late(best.term, gone[0]) else []
    at = {h.at for h in doubted if h.effect.time_power is not None}
    slips = [h for h in fit.model.hypotheses if h.effect.onset and h.at in at]  # what wanders jumps as well
    return TermSwaps(terms, fit, (*doubted, *slips), tuple(likelier))


def rivals(guesses: Sequence[Guess], fit: Fit, gone: Sequence[Hypothesis], slow: bool = False) -> Iterator[Guess]:
    """Yield the best term where effects are, and the best one elsewhere if an effect could as well be there.

    What is slow may be the noise's colour, or a drift, which has a name: such a term is held against that name alone. A
    jump is held against splines without a law as well, for three numbers and a time are no curve, and a slow curve of a
    gyroscope's, which is nothing that a joint does; where the spline is slow, one of an accelerometer's too.
    """
    own = {seen_at(h) for h in gone}
    if is_a_drift(gone):
        yield from [g for g in guesses if g.term.drift and g.term.at in own][:1]
    steady = [g for g in guesses if not g.term.drift]
    if any(h.effect.states for h in gone):  # it takes what is at either IMU
        if gone[0].effect.free:
            yield from [g for g in guesses if g.term.jumps][:1]
            curves = [g for g in guesses if g.term.drift and not g.term.jumps]
            yield from [g for g in curves if g.term.part == "gyro"][:1]
            yield from [g for g in curves if slow and g.term.part == "accel"][:1]
        yield from (next(g for g in steady if g.term.at == at) for at in dict.fromkeys(g.term.at for g in steady))
        return
    best = next((g for g in steady if g.term.at in own), None)
    if best:
        yield best
    if steady and steady[0] is not best and len(gone) == 1:
        (h,) = gone
        if (h.effect.name, steady[0].term.at) in {(r.effect, r.at) for r in equivalents(fit, h)}:
            yield steady[0]


__all__ = ["TermSwaps", "swapped_for_terms"]
