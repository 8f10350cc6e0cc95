"""Names that only stand in for something without one, on recordings of the independent generator."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.score_test import gain_of_weights
from imubench.diagnosis.discrepancy.fitted_terms import fitted_term, refit_once
from imubench.diagnosis.discrepancy.term_scores import promising
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.swap_for_term import swapped_for_terms
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.solve.schur import promise
from imubench.effects import EFFECTS, VARIANTS
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.mark.parametrize("louder", [1.0, 13.0])
def test_what_weights_win_is_the_ratio_of_marginal_densities(louder):
    rng = np.random.default_rng(2)
    signals, std = rng.normal(size=(30, 4)), 0.7
    y = signals @ rng.normal(size=4) + louder**0.5 * rng.normal(size=30)
    without = louder * np.eye(30)
    expected = multivariate_normal.logpdf(y, cov=without + std**2 * signals @ signals.T)
    expected -= multivariate_normal.logpdf(y, cov=without)
    values, vectors = np.linalg.eigh(signals.T @ signals)
    won, price = gain_of_weights(values, (vectors.T @ signals.T @ y) ** 2, std, louder)
    assert won - price == pytest.approx(expected, rel=1e-9)


def test_information_that_rounding_puts_below_nothing_still_has_a_bound():
    matrix = np.diag([4.0, -1.5])
    found = promise(matrix, np.array([2.0, 0.0]), np.array([1.0, 3.0]))
    np.testing.assert_allclose(found.bound, [1 / 5**0.5, 3.0])
    np.testing.assert_allclose(found.step, [-0.4, 0.0])
    assert found.price == pytest.approx(0.5 * np.log(5))


def fitted_with(folder, effect, at, asked, seed, rig="hinge", rounds=1, **options):
    make_case(folder / "case", rig, effects=asked, seed=seed, seconds=12.0, **options)
    fit = nominal_fit(read(folder / "case")[0])
    fit = refit(fit, (*fit.model.hypotheses, Hypothesis(effect, at)))
    return with_noise(fit, rounds)


def filter_of(channel):
    return next(e for e in VARIANTS if e.name == "low_pass" and e.channels == (channel,))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "stays"),
    [
        (("hysteresis", "imu2", {"channel": "accel", "share": 0.19, "width": 0.87}), False),
        (("low_pass", "imu2", {"cutoff": 13.0, "channels": ["accel"]}), True),
    ],
)
def test_a_filter_that_stood_in_for_hysteresis_gives_way(tmp_path, asked, stays):
    fit = fitted_with(tmp_path, filter_of("accel"), "imu2", [asked], 51, band=1.5, encoder=True)
    found = swapped_for_terms(fit)
    assert bool(found.terms) != stays
    assert any(h.effect.name == "low_pass" for h in found.fit.model.hypotheses) == stays
    assert not found.doubted


@pytest.mark.slow
def test_play_a_scale_and_a_filter_that_stood_in_for_a_dead_zone_give_way(tmp_path):
    asked = [("dead_band", "imu2", {"channel": "gyro", "width": 0.115})]
    fit = fitted_with(tmp_path, EFFECTS["joint_play"], "joint", asked, 59, "hinge", 3, band=1.1, rate=200.0)
    more = (Hypothesis(EFFECTS["gyro_scale"], "imu2"), Hypothesis(filter_of("accel"), "imu1"))
    found = swapped_for_terms(with_noise(refit(fit, (*fit.model.hypotheses, *more)), 2))
    assert {(t.term.at, t.term.part) for t in found.terms} == {("imu2", "gyro")}
    assert {h.effect.name for h in found.fit.model.hypotheses} == {"unknown"}


@pytest.mark.slow
def test_the_signals_of_what_bent_the_motion_are_taken_again(tmp_path):
    asked = [("dead_band", "imu2", {"channel": "gyro", "width": 0.115})]
    options = {"band": 1.1, "vigour": 0.6, "rate": 200.0, "gyro_noise": 0.0034, "accel_noise": 0.033}
    make_case(tmp_path / "case", "hinge", effects=asked, seed=60, seconds=12.0, **options)
    fit = nominal_fit(read(tmp_path / "case")[0])
    guesses, tried = promising(fit)
    guess = next(g for g in guesses if (g.term.at, g.term.goes_with) == ("imu2", "its own reading"))
    first, last = refit_once(fit, guess, np.log(tried)), fitted_term(fit, guess, np.log(tried))
    assert aic_gain(first.fit, last.fit) > 30
    assert all(last.fit.noise[f"{imu}.gyro"] < first.fit.noise[f"{imu}.gyro"] for imu in ("imu1", "imu2"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "parameters", "colour", "stays", "sure"),
    [
        ("thermal_walk", {"channel": "gyro", "density": 0.002}, 0.07, False, False),
        ("bias_jump", {"channel": "gyro", "jump": [-0.001, 0.0015, -0.0004], "time": 5.1}, 0.0, False, False),
        ("gyro_drift", {"rate": [0.0003, -0.0008, 0.0002]}, 0.2, True, False),  # noise as slow as that bends any line
        ("gyro_drift", {"rate": [0.0003, -0.0008, 0.0002]}, 0.0, True, True),
    ],
)
def test_a_drift_that_stood_in_for_a_walk_or_a_jump_gives_way(tmp_path, name, parameters, colour, stays, sure):
    options = {"rate": 200.0, "band": 3.6, "gyro_noise": 0.0016, "colour": colour}
    asked = [(name, "imu1", parameters)]
    fit = fitted_with(tmp_path, EFFECTS["gyro_drift"], "imu1", asked, 52, "pendulum", 3, **options)
    found = swapped_for_terms(fit)
    assert bool(found.terms) != stays
    assert any(h.effect.name == "gyro_drift" for h in found.fit.model.hypotheses) == stays
    assert bool(found.doubted) != (sure or not stays)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig", "asked", "free", "seed", "stays"),
    [
        ("hinge", ("creep", "imu2", {"rotation": [0.0, -0.066, 0.019], "time_constant": 3.9}), "joint_play", 53, False),
        ("hinge", ("joint_play", "joint"), "joint_play", 54, True),
        ("pendulum", ("cubic", "imu1", {"channel": "gyro", "factor": 0.0078}), "moving_pivot", 55, False),
        ("pendulum", ("moving_pivot", "joint"), "moving_pivot", 56, True),
        ("pendulum", ("rectification", "imu1", {"factor": [0.008, -0.01, 0.006]}), "moving_pivot", 57, False),
        ("pendulum", ("thermal_walk", "imu1", {"channel": "accel", "density": 0.04}), "moving_pivot", 58, False),
    ],
)
def test_a_spline_without_a_law_gives_way_to_a_few_weights_that_do_as_much(tmp_path, rig, asked, free, seed, stays):
    fit = fitted_with(tmp_path, EFFECTS[free], "joint", [asked], seed, rig, 3)
    found = swapped_for_terms(fit)
    assert [t.term.at for t in found.terms] == ([] if stays else [asked[1]])
    assert any(h.effect.name == free for h in found.fit.model.hypotheses) == stays
