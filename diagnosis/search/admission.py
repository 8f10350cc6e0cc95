"""What of a round comes into the fit: asked of data that it has not seen."""

from collections.abc import Callable

import numpy as np

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.criteria.cross_validation import Gain, by_halves, heldout_gain
from imubench.diagnosis.criteria.trial import Kept, Passed, Trial
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.rounds import Round, akin, asked, with_a_clock
from imubench.diagnosis.solve.levenberg_marquardt import Fit, at_noise_of

Refused = list[tuple[Hypothesis, float]]  # with what it gained on held-out data, in nat


def admitted(
    now: Round, kept: list[Kept], rng: np.random.Generator, say: Callable[[str], None]
) -> tuple[Fit, list[Kept], Refused]:
    """Return the fit and its effects with what predicts of a round, and what was refused.

    Where what is akin to the best predicts and the best only seems to, something of their kind is there, and the best
    is its name: nine numbers of a g-sensitivity were lost in blocks of 2 s (30 nat, -18 to 68), three of a bias not.
    What shows in a moment is in one block, and no other tells of it: there it must be what its law says
    (`shows_in_its_moments`).
    """
    refused: Refused = []
    top: Gain | None = None
    for best, least in asked(now.tried):
        say(f"predicting held-out data with {best.hypothesis.name}")
        better = now.first if best is now.tried[0] else with_noise(best.fit)
        won = heldout_gain(now.fit, better, rng)
        foretells = won.is_sure(least)
        if not foretells and unseen(best, won):
            won = in_halves(now.fit, better, rng)
            foretells = won.clear()
        if foretells or (now.brief and best is now.tried[0]):
            if top and top.value > 0 and akin(best, now.tried[0]):
                best, won, better, refused = now.tried[0], top, now.first, []
            break
        top = won if best is now.tried[0] else top
        refused.append((best.hypothesis, won.value))
    else:
        return all_together(now, kept, refused, rng, say)
    others = tuple(Passed(t.hypothesis, t.evidence) for t in now.tried if t is not best and not t.also)
    kept = [*kept, *(Kept(h, best.evidence, won, others) for h in (best.hypothesis, *best.also))]
    for trial in now.together if best is now.tried[0] else []:
        won = heldout_gain(better, trial.fit, rng)
        if not won.is_sure() or len(kept) == ADMISSION.most_effects - 1:
            break
        kept, better = [*kept, Kept(trial.hypothesis, trial.evidence, won, ())], trial.fit
    return better, kept, refused


def all_together(
    now: Round,
    kept: list[Kept],
    refused: Refused,
    rng: np.random.Generator,
    say: Callable[[str], None],
) -> tuple[Fit, list[Kept], Refused]:
    """Return the fit with effects that were found one after the other, each alone refused, if they predict together.

    A slip that is not known spoils what a scale foretells of other seconds, and the other way round. So does a clock's
    skew: a misalignment of 1,145 nat, the best beside it, gained 819 on held-out data and might as well have lost.
    """
    together = now.together or with_a_clock(now, say)
    if not together or len(kept) + 1 + len(together) > ADMISSION.most_effects:
        return now.fit, kept, refused
    best, last = now.tried[0], together[-1]
    some = [best.hypothesis, *(t.hypothesis for t in together)]
    say(f"predicting held-out data with {' and '.join(h.name for h in some)}")
    won = heldout_gain(now.fit, last.fit, rng)
    if not won.is_sure():
        return now.fit, kept, refused
    evidence = [best.evidence, *(t.evidence for t in together)]
    new = [Kept(h, e, won, ()) for h, e in zip(some, evidence, strict=True)]
    return last.fit, [*kept, *new], [r for r in refused if r[0] not in some]


def unseen(best: Trial, won: Gain) -> bool:
    """Return whether blocks are too short to show an effect: they cannot have gained what it is worth to the whole."""
    return not best.hypothesis.effect.states and won.high < best.evidence


def in_halves(fit: Fit, better: Fit, rng: np.random.Generator) -> Gain:
    """Return what a fit with more in it gains in each half of the recording from the other, at its noise."""
    return by_halves(at_noise_of(fit, better), better, rng)


__all__ = [
    "Refused",
    "admitted",
]
