"""A diagnosis as the suite reads it: what it says, and what of that matters."""

from dataclasses import dataclass
from pathlib import Path

from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.result import Diagnosis, Finding
from imubench.diagnosis.result_file import FILE_NAME
from imubench.diagnosis.result_read import read_diagnosis
from imubench.inputs.json import load_table


@dataclass(frozen=True)
class Said:
    """A diagnosis, and which of its findings it calls material."""

    diagnosis: Diagnosis
    material: tuple[bool, ...]  # of each finding; one that says nothing of it counts as material

    @property
    def sure(self) -> list[Finding]:
        """The findings of confidence 0.5 or more."""
        return [f for f in self.diagnosis.findings if f.confidence >= CONFIDENCE.counts]

    @property
    def alarms(self) -> list[Finding]:
        """Those that matter: sure and material."""
        pairs = zip(self.diagnosis.findings, self.material, strict=True)
        return [f for f, material in pairs if material and f.confidence >= CONFIDENCE.counts]


def read_said(folder: Path) -> Said:
    """Return what `imubench diagnose` wrote into a folder."""
    diagnosis = read_diagnosis(folder)
    findings = load_table(folder / FILE_NAME)["findings"]
    return Said(diagnosis, tuple(f.get("material", True) is not False for f in findings))


def told(finding: Finding) -> str:
    """Return a finding in words."""
    return f"{finding.effect} at {finding.at} ({finding.confidence:.2f})"
