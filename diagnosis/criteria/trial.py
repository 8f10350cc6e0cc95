"""What is known of an effect that was tried, passed over or kept: what it is worth, and what it predicts."""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import HELD_OUT
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis

TIE_NAT, TIE_SHARE = 20.0, 0.05  # nat, or of the evidence, within which two effects were as good


@dataclass(frozen=True)
class Gain:
    """What a model gains over another on data that it did not see."""

    value: float  # nat
    low: float  # 95 % of block bootstraps lie between
    high: float
    blocks: Array  # (k,) nat, of each block

    def is_sure(self, least: float = 0.0) -> bool:
        """Return whether at least so many nat are gained for sure, up to a hundredth of what is gained.

        What acts in one block only, as friction until a swing has ended, is missed by (1 - 1 / n)^n, about a third, of
        the bootstraps, and blocks that say nothing lose a little of the freedom's price: hence the hundredth. What is
        far from zero in few blocks, as the end of a clock's skew, is gained for sure too where the others say little
        against it: each block is foretold from data without it, and the mean of exp(nat) of noise alone is 1.
        """
        return (not least and self.clear()) or self.low > least - HELD_OUT.little * max(self.value, 0.0)

    def clear(self) -> bool:
        """Return whether what some blocks gain is far from nought, and little is lost by the others."""
        lost = -float(np.minimum(self.blocks, 0.0).sum())
        return self.value > EVIDENCE.clear_nat and lost < HELD_OUT.against * (float(self.blocks.sum()) + lost)


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

    @property
    def near(self) -> float:
        """The evidence in nat from which on a rival was as good."""
        return self.evidence - max(TIE_NAT, TIE_SHARE * self.evidence)

    @classmethod
    def unjudged(cls, h: Hypothesis) -> "Kept":
        """Return an effect that is in a fit without having been chosen: deletion will say what it is worth."""
        return cls(h, np.inf, Gain(0.0, 0.0, 0.0, np.zeros(1)), ())


def kind(h: Hypothesis) -> str:
    """Return an effect at its place, of whose variants a fit has one; a filter's are apart, as its triples are."""
    return h.name if h.effect.filters else f"{h.effect.name}@{h.at}"
