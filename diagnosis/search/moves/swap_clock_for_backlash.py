"""Clocks that seem late beside an encoder with play: backlash holds back what it reads at every turn of the motion.

The delay is seen before anything is fitted and is in the fit from the start. What backlash leaves beside it has another
shape than backlash: begun there its fit ended at 0.018 rad for 0.042, its law broken by 17 times its std. So it is held
against the offsets of all clocks, and begun without them: 5,400 nat more than both offsets.
"""

from contextlib import suppress

import numpy as np

from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.cross_validation import heldout_gain
from imubench.diagnosis.criteria.dynamic_score import screen
from imubench.diagnosis.criteria.plausible_fit import holds_its_law
from imubench.diagnosis.criteria.trial import Kept, Passed
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.dynamic_refits import refit_from_screening
from imubench.diagnosis.search.moves.move import Above, Foretells, Holds, Proposal, Proposals, SearchState, told
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.refit import refit
from imubench.effects import possible
from imubench.progress import tell


class ClocksToBacklash:
    """Backlash in the place of every clock's offset, if that is worth more."""

    def propose(self, state: SearchState) -> Proposals:
        """Yield the fit with backlash instead, where every clock but one has an offset."""
        fit, kept = state.fit, state.kept
        clocks = [k for k in kept if k.hypothesis.effect.late_by]
        asked = [Hypothesis(effect, at) for effect, at in possible(fit.model.recording) if effect.acts("encoder")]
        if len(clocks) < len(fit.model.recording.imus) or not asked:
            return
        others = [k for k in kept if k not in clocks]
        what = f"{asked[0].name} in the place of {' and '.join(k.hypothesis.name for k in clocks)}"
        tell(f"trying {what}")
        with suppress(NotPositiveDefiniteError):
            bare = with_noise(refit(fit, tuple(k.hypothesis for k in others)))
            trial = refit_from_screening(bare, screen(bare, asked))
            passed = tuple(Passed(k.hypothesis, k.evidence) for k in clocks)
            yield Proposal(
                what,
                lambda won: state.changed(
                    trial.fit, [*others, Kept(trial.hypothesis, trial.evidence, told(won), passed)]
                ),
                (
                    Holds(lambda: holds_its_law(trial)),
                    Above(lambda: aic_gain(fit, trial.fit), EVIDENCE.needed_nat),
                    Foretells(lambda: heldout_gain(bare, trial.fit, np.random.default_rng(STATISTICS.seed))),
                ),
            )


__all__ = ["ClocksToBacklash"]
