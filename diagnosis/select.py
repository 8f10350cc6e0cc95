"""Which effects the fit needs: score all, refit the best few exactly, keep what predicts, drop what it does without."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from imubench.diagnosis.brief import blind, blinded
from imubench.diagnosis.coarser import finer
from imubench.diagnosis.entered import MOST, Refused, entered
from imubench.diagnosis.exchange import exchanged
from imubench.diagnosis.filtered import filtered, quickly
from imubench.diagnosis.fit import Fit, converged
from imubench.diagnosis.hypothesis import Hypothesis
from imubench.diagnosis.lively_worth import as_tight, law_levels
from imubench.diagnosis.loosened import loosened
from imubench.diagnosis.merged import merged
from imubench.diagnosis.mixture import mixed, together
from imubench.diagnosis.model import Model
from imubench.diagnosis.noise import with_noise, with_settled_noise
from imubench.diagnosis.prune import SEED, natural, prune
from imubench.diagnosis.rounds import CLEARLY, Round, attempted
from imubench.diagnosis.slack import slack
from imubench.diagnosis.terms import FRICTION
from imubench.diagnosis.trial import CLOCK, FILTER, SLIP, Kept
from imubench.diagnosis.unbiased import unbiased
from imubench.effects import possible
from imubench.effects.soft_mounts import Sprung

SETTLED = 8  # rounds at most, of a law that the fit ends with


@dataclass(frozen=True)
class Selection:
    """What was found, and the fit with it."""

    fit: Fit
    kept: tuple[Kept, ...]
    rejected: tuple[tuple[Hypothesis, float], ...]  # nat on held-out data, or of evidence where that was enough

    @cached_property
    def numbers(self) -> Fit:
        """The fit that the numbers are read off."""
        return unbiased(loosened(self.fit))

    @property
    def springs_refused(self) -> frozenset[str]:
        """Return the places at which springs explained much and foretold nothing."""
        return frozenset(h.at for h, _ in self.rejected if isinstance(h.effect, Sprung))


def candidates(model: Model) -> list[Hypothesis]:
    """Return every effect at every place of a recording where it could act."""
    return [Hypothesis(effect, at) for effect, at in possible(model.recording) if effect.parameters or effect.states]


def select(nominal: Fit, say: Callable[[str], None] = lambda _: None) -> Selection:
    """Return the effects that the recording needs.

    A slip that predicts nothing is not asked for again: a loud moment of anything promises one, and hides the rest.
    """
    rejected: Refused = []
    fit, kept = slack(nominal, [Kept.unjudged(h) for h in nominal.model.hypotheses], say)
    fit, kept = quickly(fit, kept, say)
    rng = np.random.default_rng(SEED)
    everything = candidates(nominal.model)
    asked_for, vain, heard = everything, Counter[str](), set[str]()
    while len(kept) < MOST:
        now, before, masks = attempted(fit, asked_for, say, vain, heard), len(kept), fit.model.masks
        fit, kept, refused = entered(now, kept, rng, say)
        if now.fit.model.masks is not masks and not any(k.hypothesis.effect.name == SLIP for k in kept[before:]):
            fit = blinded(fit, masks)  # of a slip that was refused
        lively, heard = now.lively, heard | well_heard(now)
        del now  # with all its fits: memory
        rejected += refused
        if len(kept) > before:
            late = any(k.hypothesis.effect.name == CLOCK for k in kept[before:])
            heard = set() if late else heard
            fit, kept = exchanged(fit, kept, everything, say)
            rubs = any(k.hypothesis.effect.name in FRICTION for k in kept[before:])
            fit, kept = mixed(fit, kept, say) if rubs else (fit, kept)
            fit, kept = quickly(fit, kept, say) if late else (fit, kept)
            asked_for = everything
        elif slips := {h.name for h, _ in refused if h.effect.name == SLIP}:
            asked_for = [h for h in asked_for if h.name not in slips]
        elif refused and not lively:
            asked_for = [h for h in everything if h.effect.states]
        else:
            break
    fit, kept, dropped = prune(finer(fit), kept, say)
    for change in (mixed, merged, filtered):
        other, kept = change(fit, kept, say)
        if other is not fit:
            fit, kept, more = prune(other, kept, say)
            dropped += more
    fit = with_settled_noise(fit)
    if fit.model.tilts:
        say("settling springs and dampers")
        fit = as_tight(with_noise(fit, SETTLED, laws_of_filters(fit)))
        if not all(natural(fit, k.hypothesis) for k in kept):
            fit, kept, more = prune(fit, kept, say)
            dropped += more
    for h in [k.hypothesis for k in kept]:
        if windows := blind(fit, h):  # its course is near enough to find it by, not to read its numbers off
            fit = blinded(fit, windows)
    fit = converged(fit) if kept else fit
    return Selection(fit, tuple(together(fit, kept)), (*rejected, *dropped))


def well_heard(now: Round) -> set[str]:
    """Return the filters that were worth much in a round, whatever came in instead."""
    return {t.hypothesis.name for t in now.tried if t.hypothesis.effect.name == FILTER and t.evidence > CLEARLY}


def laws_of_filters(fit: Fit) -> list[str]:
    """Return the noise levels of filters' laws, which have settled once the filter is in.

    A sensor's slow noise behind its filter looks like noise of the law. Round by round more of it went there (0.13 to
    0.33 times the law's standard deviation, and no end), until a motion a little later explained what was left.
    """
    return law_levels(fit, [h for h in fit.model.hypotheses if h.effect.name == FILTER])


__all__ = ["Selection", "candidates", "select"]
