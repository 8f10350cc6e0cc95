"""How much of the difference comes back without a finding."""

from dataclasses import replace

import pytest

from imubench.diagnosis.report.shares import explained_share, with_shares
from tests.diagnosis.report.diagnoses import simulated
from tests.diagnosis.test_diagnosis_result import TIME


def test_shares_are_what_comes_back_without_a_finding():
    d, shown = simulated()
    n = TIME.size
    total = (1.2**2 - 0.02**2) / 0.03**2 * n / 2 + (0.04**2 - 0.002**2) / 0.005**2 * n / 2
    expected = (1.2**2 - 0.02**2) / 0.03**2 * n / 2 / total
    assert d.findings[0].share == pytest.approx(expected, rel=1e-3)  # the sampled sine's power is 1/2 to 1e-4
    assert d.findings[1].share is None  # it is not compared
    given = replace(d, findings=(replace(d.findings[0], share=0.5), d.findings[1]))
    assert with_shares(given, shown).findings[0].share == 0.5
    assert explained_share(()) is None
    assert explained_share(shown.simulated) == pytest.approx(0.9997, abs=2e-4)  # 1 - (0.02 / 1.2)^2 in the loudest
