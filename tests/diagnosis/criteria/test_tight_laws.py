"""Laws as tight as they bear, and springs beside what stands in for them, on the independent generator's data."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.dynamic_aic import judged, tightened
from imubench.diagnosis.criteria.dynamic_score import screen
from imubench.diagnosis.criteria.trial import Gain, Kept, Passed
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.dynamic_candidates import stateful
from imubench.diagnosis.search.moves.dynamic_refits import refit_from_screening
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.verdict.findings import laws_as_good
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

STIFF = ("soft_mount", "imu1", {"frequency": [43.78, 38.34, 50.54], "damping_ratio": 0.0517})


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean") / "r"
    make_case(folder, "hinge", [], 5, seconds=8.0, rate=50.0)
    return nominal_fit(read(folder)[0])


@pytest.mark.long
def test_a_spline_that_is_worth_less_than_nothing_stays_so(clean):
    """What slow noise may have given it is taken off what it gains, and off no loss."""
    h = Hypothesis(EFFECTS["joint_play"], "joint")
    begun = extended(clean, (*clean.model.hypotheses, h))
    rough = dict.fromkeys((f"smooth.{h.key(s.name)}" for s in h.effect.states), 1e3)
    tried = solve(begun.model, begun.state, begun.noise | rough, clean.anchor)
    nat = aic_gain(clean, tried)
    assert nat < 0
    assert judged(clean, [h], tried)[0].evidence == pytest.approx(nat)


@pytest.mark.slow
def test_a_stiff_mount_pays_for_no_freedom_that_its_law_does_not_need(tmp_path):
    """A law as loose as the floor of its noise lets the state follow the samples' noise, and pays for that."""
    options = {"rate": 100.0, "band": 6.33, "vigour": 1.13, "gyro_noise": 0.00442, "accel_noise": 0.01456}
    make_case(tmp_path / "r", "pendulum", [STIFF], 1479317972, seconds=15.0, **options)
    fit = nominal_fit(read(tmp_path / "r")[0])
    h = Hypothesis(EFFECTS["soft_mount"], "imu1")
    (found,) = screen(fit, [h])
    trial = refit_from_screening(fit, [found])
    law = h.key("balance")
    assert trial.fit.noise[law] < REML.law_floor / 2
    loose = with_noise(replace(trial.fit, noise=trial.fit.noise | {law: REML.law_floor}), 1)
    was, freedoms = judged(fit, [h], loose)
    _, fewer = judged(fit, [h], trial.fit)
    assert fewer < freedoms / 2
    assert trial.evidence > was.evidence + 20
    seen = np.exp(trial.fit.state.values[h.key("frequency")])
    np.testing.assert_allclose(seen, STIFF[2]["frequency"], rtol=0.25)


def test_a_law_above_its_floor_is_left_as_it_is(clean):
    h = Hypothesis(EFFECTS["rocking_mount"], "imu2")
    begun = extended(clean, (h,))
    assert min(v for n, v in begun.noise.items() if n.startswith(f"{h.name}.")) > 2 * REML.law_floor
    assert tightened(begun, [h]) is None


def test_springs_are_asked_beside_a_rival_without_states_and_filters_are_not(clean):
    left = candidates(clean.model)
    alone = {h.effect.name for h in stateful(clean, left, moving=False, rivalled=False)}
    beside = {h.effect.name for h in stateful(clean, left, moving=False, rivalled=True)}
    assert {"soft_mount", "rocking_mount", "low_pass"} <= alone
    assert beside == alone - {"low_pass"}
    assert "low_pass" in {h.effect.name for h in stateful(clean, left, moving=True, rivalled=True)}
    told = stateful(clean, left, moving=False, rivalled=True, heard={"low_pass[gyro]@imu1"})
    assert {h.name for h in told if h.effect.filters} == {"low_pass[gyro]@imu1"}  # it was worth much before
    sprung = extended(clean, (Hypothesis(EFFECTS["rocking_mount"], "imu2"),))
    assert not stateful(sprung, left, moving=False, rivalled=False)


@pytest.mark.parametrize(
    ("evidence", "at", "rival"), [(68.0, "imu2", True), (30.0, "imu2", False), (68.0, "imu1", False)]
)
def test_springs_of_another_kind_that_were_worth_as_much_are_their_like(clean, evidence, at, rival):
    h, other = Hypothesis(EFFECTS["rocking_mount"], "imu2"), Hypothesis(EFFECTS["soft_mount"], at)
    kept = Kept(h, 58.0, Gain(100.0, 50.0, 150.0, np.full(8, 12.0)), (Passed(other, evidence),))
    assert [t.hypothesis.name for t in laws_as_good(kept)] == (["soft_mount@imu2"] if rival else [])
