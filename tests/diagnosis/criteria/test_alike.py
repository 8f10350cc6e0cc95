"""What a recording cannot tell apart, on recordings of the independent generator."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.equivalence import equivalents, louder, rivals
from imubench.diagnosis.criteria.score_test import score
from imubench.diagnosis.criteria.signatures import MARK, joint_information, signature
from imubench.diagnosis.experiments.design import separation
from imubench.diagnosis.noise.coloured import Spectra
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.gauss_newton import all_rows, extended, factored
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.solve.schur import promise
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

SLIDE = {"slide": [0.01, -0.005, 0.004], "twist": [0.0, 0.0, 0.0]}


def explained(folder, asked, seed, rig="hinge", **options):
    """The fit of a generated recording with its effects in the model, and these."""
    make_case(folder / "case", rig, effects=asked, seed=seed, seconds=12.0, **options)
    fit = nominal_fit(read(folder / "case")[0])
    wanted = tuple(Hypothesis(EFFECTS[name].suited(fit.model.recording), at) for name, at, *_ in asked)
    others = tuple(h for h in fit.model.hypotheses if h.name not in {w.name for w in wanted})
    fit = refit(fit, (*others, *wanted))
    return with_noise(fit, 1), wanted


@pytest.mark.slow
def test_a_hum_fitted_at_the_other_imu_is_equalled_by_one_at_its_own(tmp_path):
    """A motion that is free carries it there: at its own it loses nothing."""
    hum = {"frequency": 23.0, "amplitude": [0.03, 0.02, 0.01]}
    make_case(tmp_path / "case", "hinge", effects=[("vibration", "imu1", hum)], seed=12, seconds=12.0)
    fit = nominal_fit(read(tmp_path / "case")[0])
    wrong = Hypothesis(EFFECTS["vibration"], "imu2")
    fit = refit(fit, (*fit.model.hypotheses, wrong), {wrong.key("frequency"): np.array([23.0])})
    fit = with_noise(fit, 1)
    assert ("vibration", "imu1") in {(r.effect, r.at) for r in equivalents(fit, wrong)}
    assert not separation(fit, wrong, [replace(wrong, at="imu1")])  # which motion would tell is not known


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "seed", "options", "equal"),
    [
        (("moving_centre", "joint"), 3, {}, {("skin_sliding", "imu1")}),
        (("skin_sliding", "imu1", SLIDE), 3, {}, {("moving_centre", "joint")}),
        (("axis_coupling", "joint"), 4, {"strength": "strong"}, {("skin_sliding", "imu2")}),
        (("time_offset", "imu2"), 5, {}, {("time_offset", "imu1")}),
        (("gravity", "world"), 3, {"base": "fixed"}, {("accel_scale", "imu1"), ("accel_scale", "imu2")}),
        (("gravity", "world"), 3, {"rig": "pendulum"}, {("accel_scale", "imu1")}),
        (("accel_scale", "imu1", {"scale": [0.006] * 3}), 5, {"rig": "pendulum"}, {("gravity", "world")}),
        (("gyro_scale", "imu1"), 6, {}, set()),
    ],
)  # fmt: skip
def test_the_equal_ones_are_named_and_no_others(tmp_path, asked, seed, options, equal):
    fit, (h,) = explained(tmp_path, [asked], seed, **options)
    assert {(r.effect, r.at) for r in equivalents(fit, h)} == equal


def test_one_scale_of_all_accelerometers_is_another_gravity(tmp_path):
    same = {"scale": [0.006] * 3}
    fit, both = explained(tmp_path, [("accel_scale", "imu1", same), ("accel_scale", "imu2", same)], 5, base="fixed")
    for h in both:
        assert ("gravity", "world") in {(r.effect, r.at) for r in equivalents(fit, h)}


@pytest.mark.slow
def test_the_expected_loss_is_that_of_a_refit(tmp_path):
    fit, (h,) = explained(tmp_path, [("accel_scale", "imu1")], 6)
    rival = next(r for r in rivals(fit, h, sure=False) if (r.effect, r.at) == ("accel_scale", "imu2"))
    begun = extended(fit, (Hypothesis(EFFECTS["accel_scale"], "imu2"),))
    lost = solve(begun.model, begun.state, begun.noise, fit.anchor, steps=6).cost - fit.cost
    assert rival.loss > 10 * EVIDENCE.needed_nat
    assert rival.loss == pytest.approx(lost, abs=3 * np.sqrt(2 * lost))  # the noise's own part of a loss


@pytest.mark.parametrize(("frequency", "expected"), [(1.0, 5.0), (12.0, 1.0)])
def test_noise_is_as_loud_as_it_is_shown_to_be_where_two_differ(frequency, expected, hardly_counting):
    fit = hardly_counting(300)
    rows = next(r for r in fit.measured if r.name == "imu1.accel")
    edges = np.array([1.0, 2.0, 6.0, 18.0, 54.0, len(rows.time) // 2 + 1])  # bins of 1/3 Hz
    shown = {rows.name: Spectra(edges, np.array([9.0, 5.0, 1.0, 1.0, 1.0]), np.ones(5))}
    wave = np.sin(2 * np.pi * frequency * rows.time)[:, None] * np.ones(3)
    assert louder(fit, {rows.name: wave}, shown) == pytest.approx(expected, rel=0.2)
    assert louder(fit, {rows.name: wave}, {}) >= 1.0


@pytest.mark.long
def test_joint_information_is_that_of_the_scores(tmp_path):
    fit, (h,) = explained(tmp_path, [("gyro_scale", "imu1")], 6)
    others = [Hypothesis(EFFECTS[name], "imu2") for name in ("gyro_bias", "accel_scale")]
    begun = extended(fit, (h, *others))
    both = joint_information(begun.model, begun.state, fit, others)
    rows = all_rows(begun.model, begun.state, fit.noise, fit.anchor, fit.loose)
    own = [h.key(p.name) for h in others for p in h.effect.parameters]
    normal, solution, _ = factored(begun.model, [r for r in rows if r.name not in {f"prior.{n}" for n in own}])
    places = begun.model.parameters.places(own)
    information, gradient = solution.reduced(normal.gradient, normal.corner_gradient, places)
    np.testing.assert_allclose(both.information, information, rtol=1e-6, atol=1e-6 * np.abs(information).max())
    np.testing.assert_allclose(both.gradient, gradient, rtol=1e-6, atol=1e-6 * np.abs(gradient).max())
    for s in score(fit, others):
        at = both.places[s.hypothesis.name]
        found = promise(both.information[np.ix_(at, at)], both.gradient[at], both.prior[at])
        # the same numbers by two ways of elimination
        assert found.gain == pytest.approx(s.gain, rel=1e-6)
        np.testing.assert_allclose(found.bound, s.bound, rtol=1e-6)
        np.testing.assert_allclose(found.step, s.estimate, rtol=1e-6, atol=1e-6 * np.abs(s.estimate).max())


@pytest.mark.slow
def test_an_effect_explains_its_own_mark(tmp_path):
    fit, (h,) = explained(tmp_path, [("gyro_bias", "imu2", {"bias": [0.01, -0.02, 0.005]})], 6)
    bare, still, added = signature(fit, fit.state, [h])
    assert set(added) == {"imu2.gyro"}
    begun = extended(fit, (h,))
    begun_state = type(still)(begun.state.coefficients, begun.state.values)
    both = joint_information(begun.model, begun_state, fit, [h], {MARK: added})
    lost, size = both.explained(both.along(MARK)[:, 0], both.along(h.name))
    assert bare.hypotheses == ()
    assert lost < 1.0  # nat: what its prior of 0.05 rad/s costs
    np.testing.assert_allclose(size, fit.state.values[h.key("bias")], rtol=0.02)  # drawn in by the prior
