"""The evidence for a clock: what the samples say, and not where they lie between the splines' knots."""

import pytest

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.drop import about_zero
from imubench.diagnosis.solve.refit import evidence_over, information, refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

RIGS = {
    "free": ("imu1", {"pose": True}),
    "hinge": ("imu2", {}),
}


@pytest.mark.long
@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("effect", ["time_offset", "clock_skew"])
def test_a_clock_s_evidence_is_that_of_its_parameter_alone(tmp_path, rig, effect):
    at, options = RIGS[rig]
    wrong = {"time_offset": {"offset": 1.1e-3}, "clock_skew": {"skew": 4e-4}}[effect]
    make_case(tmp_path / "case", rig, effects=[(effect, at, wrong)], seed=7, seconds=8.0, rate=100.0, **options)
    fit = nominal_fit(read(tmp_path / "case")[0])
    h = Hypothesis(EFFECTS[effect], at)
    assert h.name not in {other.name for other in fit.model.hypotheses}
    with_it = refit(fit, (*fit.model.hypotheses, h))
    expected = about_zero(with_it, [h], information(with_it)[0])  # of a Gaussian: exact where the law is near linear
    assert expected > 20.0
    assert evidence_over(fit, with_it) == pytest.approx(expected, abs=2.0 + 0.05 * expected)


def test_a_clock_that_is_right_has_an_evidence_below_zero(tmp_path):
    make_case(tmp_path / "case", "free", effects=[], seed=8, seconds=8.0, rate=100.0, pose=True)
    fit = nominal_fit(read(tmp_path / "case")[0])
    h = Hypothesis(EFFECTS["time_offset"], "imu1")
    if h.name in {other.name for other in fit.model.hypotheses}:
        pytest.fail("a clock that is right was in the fit from the start")
    assert -12.0 < evidence_over(fit, refit(fit, (*fit.model.hypotheses, h))) < 3.0
