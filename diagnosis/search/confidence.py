"""How sure a finding is."""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.criteria.trial import Gain
from imubench.diagnosis.result import UNKNOWN, Finding, Interval, Parameter, Where

SOFT = 2.0  # nat, how fast confidence grows beyond what is needed; not yet calibrated
MOST_SURE = 0.96  # as often as the surest findings were true in blind trials: lab 009
DOUBTFUL, STRANGE = CONFIDENCE.doubtful, CONFIDENCE.strange


def confidence(evidence: float, needed: float) -> float:
    """Return how sure a finding is that has so much evidence and needs so much, in nat."""
    return max(MOST_SURE / (1 + float(np.exp(-(min(evidence, 1e3) - needed) / SOFT))), 0.5)


def at_most(f: Finding, sure: float) -> Finding:
    """Return a finding that is no surer than that."""
    return replace(f, confidence=min(f.confidence, sure))


def nameless(at: str, sure: float, parameters: dict[str, Parameter], won: Gain, where: Where) -> Finding:
    """Return what is there without a name; the interval of what it gains holds the gain itself."""
    gain = Interval(won.value, (min(won.low, won.value), max(won.high, won.value)))
    return Finding(UNKNOWN, at, sure, parameters, gain, where=where)


__all__ = ["DOUBTFUL", "MOST_SURE", "SOFT", "STRANGE", "at_most", "confidence", "nameless"]
