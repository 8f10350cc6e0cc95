"""Which effects the fit needs: score all, refit the best few exactly, keep what predicts, drop what it does without."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from imubench.diagnosis.budget import OutOfTime, check
from imubench.diagnosis.candidates.both_mounts import gives_way
from imubench.diagnosis.config.criteria import HELD_OUT
from imubench.diagnosis.criteria.dynamic_aic import law_levels, with_tight_laws
from imubench.diagnosis.criteria.trial import Kept, kind
from imubench.diagnosis.noise.debiased_fit import debiased
from imubench.diagnosis.noise.knot_selection import finer
from imubench.diagnosis.noise.looser_motion import with_looser_motion
from imubench.diagnosis.noise.masking import mask_beside, with_mask
from imubench.diagnosis.noise.reml import with_noise, with_settled_noise
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.admission import Refused
from imubench.diagnosis.search.dynamic_candidates import suspicious
from imubench.diagnosis.search.forward import forward_selection
from imubench.diagnosis.search.moves.drop import firmly, natural, prune
from imubench.diagnosis.search.moves.merge import merged
from imubench.diagnosis.search.moves.swap_clock_for_backlash import clocks_to_backlash
from imubench.diagnosis.search.moves.swap_clock_for_filter import clock_to_filter, clock_to_quick_filter
from imubench.diagnosis.search.moves.swap_friction import best_friction, together
from imubench.diagnosis.search.rounding import without_rounded
from imubench.diagnosis.solve.levenberg_marquardt import Fit, converged
from imubench.diagnosis.traits import FILTER
from imubench.effects import possible
from imubench.effects.soft_mounts import Sprung
from imubench.progress import tell

SETTLED = 8  # rounds at most, of a law that the fit ends with
FURTHER = "further effects"
WITHOUT = "whether each finding is needed"
OTHERWISE = "other readings of the findings: one effect for two, a filter for a delay"
SETTLING = "the last digits of the findings' numbers"
STAGES = (FURTHER, WITHOUT, OTHERWISE, SETTLING)


@dataclass(frozen=True)
class Selection:
    """What was found, and the fit with it."""

    fit: Fit
    kept: tuple[Kept, ...]
    rejected: tuple[tuple[Hypothesis, float], ...]  # nat on held-out data, or of evidence where that was enough
    not_tried: tuple[str, ...] = ()  # stages of the search that the time limit did not allow

    @cached_property
    def numbers(self) -> Fit:
        """The fit that the numbers are read off; where springs predict best, and not where they cost least."""
        return self.fit if gives_way(self.fit) else debiased(with_looser_motion(self.fit))

    @property
    def springs_refused(self) -> frozenset[str]:
        """Return the places at which springs explained much and foretold nothing."""
        return frozenset(h.at for h, _ in self.rejected if isinstance(h.effect, Sprung))


def candidates(model: Model) -> list[Hypothesis]:
    """Return every effect at every place of a recording where it could act."""
    return [Hypothesis(effect, at) for effect, at in possible(model.recording) if effect.parameters or effect.states]


def select(nominal: Fit, say: Callable[[str], None] = tell, rounding: Mapping[str, float] | None = None) -> Selection:
    """Return the effects that the recording needs.

    An effect with states that is dropped in the end hid what it stood for: a filter of both triples took what a soft
    mount did (1,591 nat for 1,257), and was none once a scale and a drift were in. So the search goes on without it.
    `rounding` says what a state may gain of it, in nat by place. Where the time limit stops it, what it has by then is
    returned, with what was not tried.
    """
    fit, kept = nominal, [Kept.unjudged(h) for h in nominal.model.judged]
    rejected: Refused = []
    dropped: Refused = []
    left = list(STAGES)
    try:
        if gives_way(fit):  # at its least cost springs take in what is not theirs: where they predict best is enough
            fit, kept, dropped = prune(fit, kept, say)
            return Selection(fit, tuple(kept), tuple(dropped))
        fit, kept = clocks_to_backlash(fit, kept, say)
        fit, kept = clock_to_quick_filter(fit, kept, say)
        rng = np.random.default_rng(HELD_OUT.bootstrap_seed)
        everything = candidates(nominal.model)
        fit, kept, rejected = forward_selection(fit, kept, everything, rng, say)
        check()
        left.remove(FURTHER)
        fine = finer(fit)
        firm = firmly(fit, kept) if fine is not fit else ()
        fit, kept, dropped = prune(fine, kept, say, firm)
        if (hollow := {kind(h) for h, _ in dropped if h.effect.states}) and suspicious(fit):
            say("searching anew without what was none")
            rest = [h for h in everything if kind(h) not in hollow]
            fit, kept, refused = forward_selection(fit, kept, rest, rng, say)
            rejected = [*rejected, *refused]
            fit, kept, more = prune(fit, kept, say, firm)
            dropped += more
        fit, kept, gone = without_rounded(fit, kept, rounding or {})
        if gone:
            dropped += ((k.hypothesis, k.heldout.value) for k in gone)
            fit, kept, more = prune(fit, kept, say, firm)
            dropped += more
        left.remove(WITHOUT)
        for change in (best_friction, merged, clock_to_filter):
            before = fit
            fit, kept = change(fit, kept, say)
            if fit is not before:
                fit, kept, more = prune(fit, kept, say, firm)
                dropped += more
        left.remove(OTHERWISE)
        fit = with_settled_noise(fit)
        if fit.model.tilts:
            say("settling springs and dampers")
            fit = with_tight_laws(with_noise(fit, SETTLED, laws_of_filters(fit)))
            if not all(natural(fit, k.hypothesis) for k in kept):
                fit, kept, more = prune(fit, kept, say, firm)
                dropped += more
        for h in [k.hypothesis for k in kept]:
            if windows := mask_beside(fit, h):  # its course is near enough to find it by, not to read its numbers off
                fit = with_mask(fit, windows)
        fit = converged(fit) if kept else fit
        kept, left = together(fit, kept), []
    except OutOfTime:
        pass  # what is in `fit` and `kept` goes together whenever a step is stopped
    return Selection(fit, tuple(kept), (*rejected, *dropped), tuple(left))


def laws_of_filters(fit: Fit) -> list[str]:
    """Return the noise levels of filters' laws, which have settled once the filter is in.

    A sensor's slow noise behind its filter looks like noise of the law. Round by round more of it went there (0.13 to
    0.33 times the law's standard deviation, and no end), until a motion a little later explained what was left.
    """
    return law_levels(fit, [h for h in fit.model.hypotheses if h.effect.name == FILTER])


__all__ = ["Selection", "candidates", "select"]
