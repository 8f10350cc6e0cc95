"""What has no name: its findings, and the fit with terms for it."""

from dataclasses import dataclass

from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.result import Finding


@dataclass(frozen=True)
class Unknowns:
    """What has no name."""

    findings: tuple[Finding, ...]
    fit: Fit  # with terms for it; without the names that only stood in for them
    doubted: tuple[Hypothesis, ...]  # names that something without one explains as well
