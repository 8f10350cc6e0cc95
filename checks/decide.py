"""One claim decided: runs are added until there is enough evidence for it or against it."""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from imubench.checks.claim import Claim
from imubench.checks.evidence import Evidence, PairedTest, log_ratio
from imubench.checks.figures import why_missing
from imubench.checks.runs import Outcome

Verdict = Literal["holds", "fails", "undecided"]


@dataclass
class Decision:
    """What the runs so far say about a claim, or about it beside a baseline."""

    claim: Claim
    evidence: Evidence
    baseline: dict[int, float] | None = None  # errors in rad or m by run, inf without an estimate; None: the bound
    verdict: Verdict | None = None  # None: not decided yet
    why_undecided: str = ""
    errors: list[float] = field(default_factory=list)  # rad or m, of the runs that it was decided by, in order
    others: list[float] = field(default_factory=list)  # the baseline's, of the same runs
    missing: list[tuple[int, str]] = field(default_factory=list)  # runs without the figure, and why

    def add(self, number: int, outcome: Outcome) -> float:
        """Take in a run, unless all is decided; return its error, inf where it has none."""
        error = self.claim_error(outcome)
        if self.verdict is not None:
            return error
        if self.baseline is not None and number not in self.baseline:
            self._end(f"the baseline has {len(self.baseline)} runs, which do not decide it")
            return error
        self.errors.append(error)
        if math.isinf(error):
            self.missing.append((number, outcome.why or self._why(outcome)))
        if self.baseline is None:
            self.evidence.add(error)
        else:
            self.others.append(self.baseline[number])
            self.evidence.add(log_ratio(error, self.baseline[number]))
        if self.evidence.against >= -math.log1p(-self.claim.confidence):
            self.verdict = "fails"
        elif self.evidence.for_it >= -math.log1p(-self.power):
            self.verdict = "holds"
        elif len(self.errors) >= self.claim.max_runs:
            self._end(f"max_runs = {self.claim.max_runs} do not decide it")
        return error

    def claim_error(self, outcome: Outcome) -> float:
        """Return the error of a run; inf where it has no such figure."""
        return outcome.figures.get(self.claim.figure, math.inf)

    @property
    def power(self) -> float:
        """1 - the probability that what is broken is passed: higher beside a baseline, where it is asked every day."""
        return self.claim.power if self.baseline is None else self.claim.baseline_power

    @property
    def runs(self) -> int:
        """How many runs it was decided by."""
        return len(self.errors)

    @property
    def measured(self) -> float:
        """The figure over those runs: what is claimed (rad, m or a share), or the median ratio to the baseline's."""
        if not self.errors:
            return math.nan
        errors = np.asarray(self.errors)
        if self.baseline is not None:
            ratios = [log_ratio(*pair) for pair in zip(self.errors, self.others, strict=True)]
            return math.exp(min(float(np.median(ratios)), math.log(1e6)))
        if self.claim.over == "share":
            return float(np.mean(errors <= self.claim.bound.si))
        if self.claim.over == "median":
            return float(np.median(errors))
        return float(np.sqrt(np.mean(errors**2)) if self.claim.over == "rms" else np.mean(errors))

    def _why(self, outcome: Outcome) -> str:
        return why_missing(self.claim.figure, outcome.figures, self.claim.named)

    def _end(self, why: str) -> None:
        self.verdict, self.why_undecided = "undecided", why


def about_the_bound(claim: Claim) -> Decision:
    """Return the decision whether a claim's bound is kept."""
    return Decision(claim, claim.evidence)


def beside_the_baseline(claim: Claim, baseline: dict[int, float]) -> Decision:
    """Return the decision whether an estimator errs as its baseline does, or more by the claim's margin."""
    return Decision(claim, PairedTest(claim.margin), baseline)
