"""Clocks that seem late beside an encoder with play: backlash holds back what it reads at every turn of the motion.

The delay is seen before anything is fitted and is in the fit from the start. What backlash leaves beside it has another
shape than backlash: begun there its fit ended at 0.018 rad for 0.042, its law broken by 17 times its std. So it is held
against the offsets of all clocks, and begun without them: 5,400 nat more than both offsets.
"""

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from imubench.diagnosis.config.criteria import HELD_OUT
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.cross_validation import heldout_gain
from imubench.diagnosis.criteria.dynamic_aic import holds_its_law
from imubench.diagnosis.criteria.dynamic_score import screen
from imubench.diagnosis.criteria.trial import Kept, Passed
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.dynamic_refits import refit_from_screening
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.levenberg_marquardt import Fit
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.traits import CLOCK
from imubench.effects import possible

BACKLASH = "backlash"


def clocks_to_backlash(fit: Fit, kept: list[Kept], say: Callable[[str], None]) -> tuple[Fit, list[Kept]]:
    """Return the fit and its effects, with backlash in the place of every clock's offset if that is worth more."""
    clocks = [k for k in kept if k.hypothesis.effect.name == CLOCK]
    asked = [Hypothesis(effect, at) for effect, at in possible(fit.model.recording) if effect.name == BACKLASH]
    if len(clocks) < len(fit.model.recording.imus) or not asked:
        return fit, kept
    others = [k for k in kept if k not in clocks]
    say(f"trying {asked[0].name} in the place of {' and '.join(k.hypothesis.name for k in clocks)}")
    with suppress(NotPositiveDefiniteError):
        bare = with_noise(refit(fit, tuple(k.hypothesis for k in others)))
        trial = refit_from_screening(bare, screen(bare, asked))
        if holds_its_law(trial) and aic_gain(fit, trial.fit) > EVIDENCE.needed_nat:
            won = heldout_gain(bare, trial.fit, np.random.default_rng(HELD_OUT.bootstrap_seed))
            if won.is_sure():
                passed = tuple(Passed(k.hypothesis, k.evidence) for k in clocks)
                return trial.fit, [*others, Kept(trial.hypothesis, trial.evidence, won, passed)]
    return fit, kept


__all__ = ["clocks_to_backlash"]
