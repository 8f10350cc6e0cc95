"""Where a joint's spring rests is read off springs at rest at some angles: without a stiffness it does nothing."""

import numpy as np
import pytest

from imubench.diagnosis.candidates.grids import at_best_rest_angle
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.refit import evidence_over, refit
from imubench.diagnosis.solve.schur import Base
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.mark.parametrize("rest", [-0.74, 0.4])
def test_a_spring_at_rest_elsewhere_is_worth_more_than_one_at_rest_at_none(rest, tmp_path):
    asked = [("joint_spring", "joint", {"k": 0.12, "q0": rest})]
    make_case(tmp_path / "r", "hinge", asked, 31, seconds=8.0, base="fixed", swing=True, encoder=True)
    fit = nominal_fit(read(tmp_path / "r")[0])
    plain = Hypothesis(EFFECTS["joint_spring"], "joint")
    found = at_best_rest_angle(Base.of(fit), plain)
    start = dict(zip(("k", "q0"), (p.start for p in found.hypothesis.effect.parameters), strict=True))
    assert abs(np.array(start["q0"]) - rest) < 0.13 + 0.1  # half the grid, and the gap that the linear score has
    assert start["k"] == 0.0  # no spring is the prior's middle
    known = evidence_over(fit, refit(fit, (plain,), {plain.key("k"): [0.12], plain.key("q0"): [rest]}, 12))
    assert found.evidence > 0.9 * known and found.evidence > 30
    assert evidence_over(fit, refit(fit, (found.hypothesis,))) > 0.95 * known
