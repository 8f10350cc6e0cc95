"""What must be said of a recording: each kind of it checks a diagnosis."""

from dataclasses import dataclass
from typing import Protocol

from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.diagnosis.search.confidence import DOUBTFUL


class Said(Protocol):
    """What must be said of a recording."""

    def check(self, diagnosis: Diagnosis) -> None:
        """Raise `AssertionError` where the diagnosis says something else."""


def found(diagnosis: Diagnosis) -> list[Finding]:
    """Return the findings that count: from confidence 0.5 on."""
    return [f for f in diagnosis.findings if f.confidence >= CONFIDENCE.counts]


def named(findings: list[Finding]) -> set[str]:
    """Return effects and places as `"EFFECT PLACE"`."""
    return {f"{f.effect} {f.at}" for f in findings}


class Exactly:
    """These findings count and no others."""

    def __init__(self, *findings: str) -> None:
        self.findings = set(findings)

    def check(self, diagnosis: Diagnosis) -> None:
        """Compare them, in any order."""
        assert named(found(diagnosis)) == self.findings


@dataclass(frozen=True)
class First:
    """The first finding is this one, whatever stands after it."""

    finding: str

    def check(self, diagnosis: Diagnosis) -> None:
        """Look at the first alone."""
        assert named([diagnosis.findings[0]]) == {self.finding}


@dataclass(frozen=True)
class EqualToFirst:
    """This explanation is among the few that equal the first finding that counts."""

    finding: str

    def check(self, diagnosis: Diagnosis) -> None:
        """Look for it, and at how many there are."""
        first = found(diagnosis)[0]
        assert self.finding in {f"{r.effect} {r.at}" for r in first.equivalent}
        assert len(first.equivalent) < 5  # were it among nearly all effects, that would tell nothing


@dataclass(frozen=True)
class Doubted:
    """No finding of an effect, or of any that has a name, is more than doubtful."""

    effect: str = ""  # "": any that has a name

    def check(self, diagnosis: Diagnosis) -> None:
        """Look at all of them."""
        asked = [f for f in diagnosis.findings if (f.effect == self.effect if self.effect else f.named)]
        assert all(f.confidence <= DOUBTFUL for f in asked)


@dataclass(frozen=True)
class Sure:
    """An effect is found with a confidence above 0.9."""

    effect: str

    def check(self, diagnosis: Diagnosis) -> None:
        """Look at the last finding of the effect."""
        assert {f.effect: f.confidence for f in diagnosis.findings}[self.effect] > 0.9


@dataclass(frozen=True)
class SomethingUnnamed:
    """Something is found that has no name."""

    def check(self, diagnosis: Diagnosis) -> None:
        """Look for one."""
        assert any(not f.named for f in diagnosis.findings)


class NothingBut:
    """No effects are found but, maybe, these; doubtful findings are findings too."""

    def __init__(self, *effects: str) -> None:
        self.effects = set(effects)

    def check(self, diagnosis: Diagnosis) -> None:
        """Compare them."""
        assert {f.effect for f in diagnosis.findings} <= self.effects


@dataclass(frozen=True)
class Number:
    """The only finding has a parameter near its true value."""

    finding: str
    parameter: str
    true: float  # in the parameter's unit
    closest: float  # in the same unit; three stated deviations must be less

    def check(self, diagnosis: Diagnosis) -> None:
        """Hold the value to three of its deviations, and these to `closest`."""
        assert [f"{f.effect} {f.at}" for f in diagnosis.findings] == [self.finding]
        told = diagnosis.findings[0].parameters[self.parameter]
        assert abs(told.value - self.true) < 3 * told.std < self.closest
