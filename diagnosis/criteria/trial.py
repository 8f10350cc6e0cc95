"""What a refit with one effect more is worth, and what an effect that stays has gained."""

from dataclasses import dataclass

import numpy as np

from imubench.diagnosis.criteria.cross_validation import Gain
from imubench.diagnosis.noise.reml import declared
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.samples.rest_noise import quietest


@dataclass(frozen=True)
class Trial:
    """A refit with one effect more."""

    hypothesis: Hypothesis
    fit: Fit
    evidence: float  # nat, over the fit without
    also: tuple[Hypothesis, ...] = ()  # a second one that came with it


@dataclass(frozen=True)
class Passed:
    """An effect that was passed over for another one, without its fit: a long recording's has a hundred megabytes."""

    hypothesis: Hypothesis
    evidence: float  # nat


@dataclass(frozen=True)
class Kept:
    """An effect that stays."""

    hypothesis: Hypothesis
    evidence: float  # nat, over the model without it
    heldout: Gain
    rivals: tuple[Passed, ...]  # refitted in its round, in its place
    ties: tuple[Passed, ...] = ()  # what in the end was as good in its place; their evidence is over the fit with it

    @classmethod
    def unjudged(cls, h: Hypothesis) -> "Kept":
        """Return an effect that is in a fit without having been chosen: deletion will say what it is worth."""
        return cls(h, np.inf, Gain(0.0, 0.0, 0.0, np.zeros(1)), ())


def kind(h: Hypothesis) -> str:
    """Return an effect at its place, of whose variants a fit has one; a filter's are apart, as its triples are."""
    return h.name if h.effect.filters else f"{h.effect.name}@{h.at}"


def misfit(fit: Fit, at_least: bool = False) -> float:
    """Return the mean over the sensors of noise power left over noise power expected.

    Expected is what is declared, or where nothing is what the IMU leaves in its quietest moments, if that may be an
    IMU's noise. One that hums has
    louder moments (its gyroscope turns with the hum): undeclared, its level says nothing. `at_least`: over the louder
    of both, for what is declared may be too little.
    """
    steady = tuple(i for i in fit.model.recording.imus if i.name not in fit.model.humming)
    quiet = quietest(steady)
    told = quiet | declared(fit.model)
    if at_least:
        told = {name: max(std, quiet.get(name, 0.0)) for name, std in told.items()}
    return float(np.mean([(fit.noise[n] / std) ** 2 for n, std in told.items() if n in fit.noise] or [1.0]))


def breaks_its_law(fit: Fit, h: Hypothesis) -> bool:
    """Return whether an effect's states leave more of their law than it allows, and so are splines.

    A filter's own readings break its law by a tenth of its std; readings that a filter cannot make leave several.
    """
    return any(std > 1.0 for name, std in fit.noise.items() if h.effect.lawful and name.startswith(h.key("")))
