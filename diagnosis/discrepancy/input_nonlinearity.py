"""Whether a sensor seems to read by a law of its own: then nothing needs to move, and no spring is sought.

A dead zone or a saturation is a function of the reading alone: one curve over it explains most of the excess, and
rounds of springs are in vain. What moves shows in more than the reading that it enters, so of springs, skin and pivots
such a curve takes a small part, or promises less than another term.
"""

from contextlib import suppress

import numpy as np

from imubench.diagnosis.config.discrepancy import TERM
from imubench.diagnosis.discrepancy.fitted_terms import refit_once
from imubench.diagnosis.discrepancy.term_scores import promising
from imubench.diagnosis.discrepancy.terms import OWN
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError


def reads_by_own_law(fit: Fit) -> bool:
    """Return whether a curve over a sensor's own reading explains most of what a fit leaves, and nothing else does."""
    guesses, tried = promising(fit)
    own = [g for g in guesses if g.term.goes_with.startswith(OWN)]
    best = max(own, key=lambda g: g.evidence, default=None)
    rival = max((g.evidence for g in guesses if g not in own), default=0.0)
    if best is None or best.evidence < max(TERM.bends_nat, rival / TERM.rival):
        return False
    with suppress(NotPositiveDefiniteError):
        found, before = refit_once(fit, best, float(np.log(tried))), misfit(fit)
        taken = before - misfit(found.fit) > TERM.own_law_takes * (before - 1)
        return taken and found.evidence > TERM.bends_nat and found.heldout.is_sure()
    return False


__all__ = ["reads_by_own_law"]
