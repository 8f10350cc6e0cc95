"""How a diagnosis begins: the raw samples checked, and the motion fitted to what is left of them."""

from dataclasses import dataclass, replace

from imubench.diagnosis.coarser import coarsest
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.nominal import nominal_fit
from imubench.diagnosis.samples import Sampled, sampled
from imubench.diagnosis.stops import STOP, UNSETTLED, settled_between, stop_of
from imubench.effects import EFFECTS
from imubench.progress import Step, silent
from imubench.recording import Recording


@dataclass(frozen=True)
class Begun:
    """A recording's samples and the motion without any effect."""

    samples: Sampled
    first: Fit  # of the model as it was declared
    fit: Fit  # where no end stop knocks, on as few knots as it needs; the search for effects goes on from here


def begun(recording: Recording, step: Step = silent) -> Begun:
    """Return what a recording shows before anything is looked for."""
    with step("check the samples"):
        samples = sampled(recording)
    with step("fit the motion"):
        known = samples.heard(recording)
        fit = first = nominal_fit(known, samples.masks, samples.humming, samples.wander)
        if STOP in EFFECTS and (stop := stop_of(first, samples)):
            known = replace(known, free_swings=stop.swings(known.free_swings))
            without = nominal_fit(known, stop.masks(first, samples.masks), samples.humming, samples.wander)
            stop = settled_between(stop, without)
            if stop.std < UNSETTLED:
                fit, samples = without, stop.told(samples)
        fit = coarsest(fit)
    return Begun(samples, first, fit)
