"""The search: round by round what explains most comes in, where data that it has not seen bear it out."""

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from imubench.diagnosis.budget import OutOfTime
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.noise.masking import with_mask
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.admission import Refused, admitted
from imubench.diagnosis.search.moves.add_dynamic import Vain
from imubench.diagnosis.search.moves.swap_clock_for_filter import clock_to_quick_filter
from imubench.diagnosis.search.moves.swap_for_one_triple import filter_to_one_triple
from imubench.diagnosis.search.moves.swap_for_rival import swapped_for_rivals
from imubench.diagnosis.search.moves.swap_friction import best_friction
from imubench.diagnosis.search.rounds import CLEARLY, Round, try_round
from imubench.diagnosis.solve.levenberg_marquardt import Fit
from imubench.diagnosis.traits import CLOCK, FILTER, FRICTION, SLIP


def forward_selection(
    fit: Fit, kept: list[Kept], everything: list[Hypothesis], rng: np.random.Generator, say: Callable[[str], None]
) -> tuple[Fit, list[Kept], Refused]:
    """Return the fit with more of some effects, all that it has, and what was refused.

    A slip that predicts nothing is not asked for again: a loud moment of anything promises one, and hides the rest.
    Where the time limit stops a round, what the rounds before brought is returned.
    """
    rejected: Refused = []
    vain: Vain = {}
    asked_for, heard = everything, set[str]()
    with suppress(OutOfTime):
        while len(kept) < ADMISSION.most_effects:
            now, before, masks = try_round(fit, asked_for, say, vain, heard), len(kept), fit.model.masks
            fit, kept, refused = admitted(now, kept, rng, say)
            if now.fit.model.masks is not masks and not any(k.hypothesis.effect.name == SLIP for k in kept[before:]):
                fit = with_mask(fit, masks)  # of a slip that was refused
            lively, heard = now.lively, heard | well_heard(now)
            del now  # with all its fits: memory
            rejected += refused
            if len(kept) > before:
                late = any(k.hypothesis.effect.name == CLOCK for k in kept[before:])
                heard = set() if late else heard
                fit, kept = swapped_for_rivals(fit, kept, everything, say)
                fit, kept = filter_to_one_triple(fit, kept, everything, rng, say)
                rubs = any(k.hypothesis.effect.name in FRICTION for k in kept[before:])
                fit, kept = best_friction(fit, kept, say) if rubs else (fit, kept)
                fit, kept = clock_to_quick_filter(fit, kept, say) if late else (fit, kept)
                asked_for = everything
            elif slips := {h.name for h, _ in refused if h.effect.name == SLIP}:
                asked_for = [h for h in asked_for if h.name not in slips]
            elif refused and not lively:
                asked_for = [h for h in everything if h.effect.states]
            else:
                break
    return fit, kept, rejected


def well_heard(now: Round) -> set[str]:
    """Return the filters that were worth much in a round, whatever came in instead."""
    return {t.hypothesis.name for t in now.tried if t.hypothesis.effect.name == FILTER and t.evidence > CLEARLY}


__all__ = ["forward_selection"]
