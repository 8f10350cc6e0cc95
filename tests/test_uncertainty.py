"""Section 6 of Olsson 2020: local and sequential uncertainty, by hand, against closed forms, and as coverage."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.coverage import CASES, runs
from benchmarks.hinge_rigs import random_rig
from imubench.estimators import hinge_fit
from imubench.estimators.hinge_constraints import weigh
from imubench.estimators.hinge_fit import covariance, local_covariance
from imubench.estimators.olsson2020 import W_ACCEL, W_GYRO, solve
from imubench.estimators.rice import expected_length
from imubench.estimators.spherical import coordinates, turn
from imubench.estimators.uncertainty import (
    Acceptance,
    deviations,
    local_uncertainty,
    monte_carlo,
    of_axes,
    paper_covariance,
    sequential_deviation,
    signed_like,
    small_angle,
    two_sigma,
)
from imubench.rotations import angle_between

NOISE = 0.002, 0.02  # rad/s, m/s^2
SMALL = np.full(2, math.radians(0.5))
X, Y, Z = np.eye(3)


def degrees(*angles):
    """Axes in the x-y plane at these angles from x."""
    return np.array([[math.cos(math.radians(a)), math.sin(math.radians(a)), 0.0] for a in angles])


def solution(seed=0, count=600):
    rig = random_rig(np.random.default_rng(seed), count, 50.0, lever=0.0).noisy(np.random.default_rng(1), *NOISE)
    return solve(*rig.gyro, *rig.accel, coordinates(rig.axes))[0]


# --- local uncertainty ---


def test_the_papers_covariance_is_eq_57():
    s = solution()
    np.testing.assert_allclose(paper_covariance(s), local_covariance(s), rtol=1e-9)  # condition number 1e3


def test_no_covariance_without_information():
    rig = random_rig(np.random.default_rng(0), 100, 50.0)
    still = np.zeros((100, 3))
    s, _ = solve(still, still, *np.repeat(rig.accel[:, :1], 100, axis=1), np.zeros(4))
    assert paper_covariance(s) is None
    assert (local_uncertainty(None, np.random.default_rng(0), 10) == math.pi).all()


@given(st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4), st.integers(0, 1000))
def test_deviations_are_the_angles_of_eq_60(step, seed):
    frames = np.linalg.qr(np.random.default_rng(seed).normal(size=(2, 3, 3)))[0]
    frames[np.linalg.det(frames) < 0] *= -1
    moved = turn(frames, np.array(step))[:, 0]
    np.testing.assert_allclose(deviations(np.array(step)), angle_between(moved, frames[:, 0]), atol=1e-12)  # rounding


def test_small_deviations_keep_their_digits():
    np.testing.assert_allclose(deviations(np.array([3e-9, 4e-9, 0.0, 1e-12])), [5e-9, 1e-12], rtol=1e-12)  # rounding


@pytest.mark.parametrize("scale", [1e-4, 0.01])
def test_monte_carlo_agrees_with_the_closed_form_where_angles_are_small(scale):
    rng = np.random.default_rng(0)
    root = rng.normal(size=(4, 4)) * [1.0, 0.3, 2.0, 0.01]
    covariance = scale**2 * root.T @ root
    drawn, exact = monte_carlo(covariance, rng, 200_000), small_angle(covariance)
    # Standard errors: sigma / sqrt(L) = 0.2 % of sigma, which is below the mean; 5 of them, and angles squared / 6.
    for one, other in zip(drawn, exact, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.012)


def test_closed_form_of_round_and_flat_regions():
    mean, std = small_angle(np.diag([1e-4, 1e-4, 4e-4, 0.0]))
    np.testing.assert_allclose(mean, [0.01 * math.sqrt(math.pi / 2), 0.02 * math.sqrt(2 / math.pi)], rtol=1e-12)
    np.testing.assert_allclose(std, [0.01 * math.sqrt(2 - math.pi / 2), 0.02 * math.sqrt(1 - 2 / math.pi)], rtol=1e-12)
    np.testing.assert_allclose(two_sigma(np.diag([1e-4, 1e-4, 4e-4, 0.0])), mean + 2 * std, rtol=1e-15)


def test_wide_regions_stay_below_half_a_turn():
    mean, _ = monte_carlo(100.0 * np.eye(4), np.random.default_rng(0), 20_000)
    assert (mean > 1.4).all()  # steps of ten radians wrap around the sphere; uniform axes would give pi / 2
    assert (mean < 1.75).all()


def test_the_draws_depend_on_the_generator_alone():
    p = paper_covariance(solution())
    first, second, other = (local_uncertainty(p, np.random.default_rng(seed), 100) for seed in (3, 3, 4))
    assert (first == second).all()
    assert (first != other).any()


def test_covariance_of_axes_turns_with_their_sign():
    s = solution()
    p = local_covariance(s)
    same, turned = of_axes(p, s, s.axes), of_axes(p, s, s.axes * [[1.0], [-1.0]])
    np.testing.assert_allclose(turned[:3, 3:], -same[:3, 3:], rtol=1e-12)  # rounding
    np.testing.assert_allclose(turned[3:, 3:], same[3:, 3:], rtol=1e-12)
    assert np.trace(same) == pytest.approx(np.trace(p))  # the chart is orthonormal


# --- the expected Hessian ---


@pytest.mark.parametrize("length", [0.0, 1e-3, 0.1, 0.5, 3.0])
def test_expected_length_is_that_of_noisy_vectors(length):
    noise = np.random.default_rng(0).normal(scale=0.3, size=(2, 400_000))
    drawn = np.hypot(length + noise[0], noise[1])
    mean = expected_length(np.array([length]), 0.3)[0]
    assert mean == pytest.approx(drawn.mean(), abs=5 * 0.3 / math.sqrt(400_000))  # 5 standard errors at most


def test_bends_of_the_expected_length_by_finite_differences():
    lengths, h = np.array([0.0, 0.2, 0.7, 2.0]), 1e-4

    def mean(along, across):
        return expected_length(np.hypot(lengths + along, across), 0.3)[0]

    _, along, across = expected_length(lengths, 0.3)
    for bend, step in ((along, (h, 0.0)), (across, (0.0, h))):
        numerical = (mean(*step) - 2 * mean(0.0, 0.0) + mean(-step[0], -step[1])) / h**2
        np.testing.assert_allclose(bend, numerical, atol=1e-6)  # rounding, 1e-16 / h^2, and truncation


def test_a_vector_far_above_the_noise_is_bent_as_without():
    mean, along, across = expected_length(np.array([2.0]), 1e-6)
    np.testing.assert_allclose([mean[0], along[0], across[0]], [2.0, 0.0, 0.5], atol=1e-9)  # (std / length)^2


def test_the_expected_hessian_is_the_mean_over_the_noise():
    rig = random_rig(np.random.default_rng(3), 500, 50.0, lever=0.0, planar=True)
    found, expected = [], []
    for run in range(400):
        one = rig.noisy(np.random.default_rng(run), *NOISE)
        point = hinge_fit._evaluate(weigh(*one.gyro, *one.accel), hinge_fit.chart(coordinates(rig.axes)))
        rows = hinge_fit._gyro_gradients(point)
        found.append(hinge_fit._outer(rows) + hinge_fit._curvature(point, rows))
        expected.append(hinge_fit._expected_hessian(point, NOISE[0]))
    scale = np.abs(np.mean(found, axis=0)).max()
    scatter = np.std(found, axis=0).max()
    np.testing.assert_allclose(np.mean(found, axis=0) / scale, np.mean(expected, axis=0) / scale, atol=0.1)  # scatter
    assert np.std(expected, axis=0).max() < 0.4 * scatter  # which is what it is for


def test_planar_motion_without_noise_has_a_covariance():
    rig = random_rig(np.random.default_rng(0), 600, 20.0, lever=0.0, planar=True)
    s, _ = solve(*rig.gyro, *rig.accel, coordinates(rig.axes))
    found = covariance(weigh(*rig.gyro, *rig.accel, W_GYRO, W_ACCEL), s)
    assert found is not None
    assert np.abs(found).max() < 1e-16  # rad^2: errors of rounding


# --- sequences ---


def test_signs_follow_the_estimate_before():
    before = degrees(0, 90)
    assert (signed_like(degrees(2, 91), before) == degrees(2, 91)).all()
    assert (signed_like(-degrees(2, 91), before) == degrees(2, 91)).all()


def test_only_one_axis_has_to_agree():
    # j2 has changed its sign, which is the other pairing: the nearer of the two axes decides, eq. (66).
    before, now = degrees(0, 90), degrees(1, 90 + 180 + 5)
    assert (signed_like(now, before) == now).all()  # j1 is 1 deg off, -j2 would be 5 deg off
    assert math.degrees(sequential_deviation(now, before)) == pytest.approx(175.0)
    now = degrees(7, 90 + 180 + 5)
    assert (signed_like(now, before) == -now).all()
    assert math.degrees(sequential_deviation(-now, before)) == pytest.approx(173.0)


def test_seqad_is_the_larger_angle_and_pi_at_first():
    assert sequential_deviation(degrees(0, 90), None) == math.pi
    assert math.degrees(sequential_deviation(degrees(4, 91), degrees(0, 90))) == pytest.approx(4.0)


def judge(n_min, estimates, local=SMALL):
    acceptance = Acceptance(math.radians(3.0), n_min)
    return [acceptance.update(axes, local) for axes in estimates]


def test_acceptance_needs_n_min_steps_and_so_one_estimate_more():
    still = judge(3, [degrees(0, 90)] * 6)
    assert [v.accepted for v in still] == [False, False, False, True, True, True]
    assert [v.worst_seqad == math.pi for v in still] == [True, True, True, False, False, False]


def test_a_jump_starts_the_count_anew():
    jump = judge(2, [degrees(0, 90)] * 3 + [degrees(10, 90)] * 3)
    assert [v.accepted for v in jump] == [False, False, True, False, False, True]


def test_a_slow_drift_passes_because_only_steps_are_compared():
    drift = judge(3, [degrees(2.5 * k, 90) for k in range(8)])
    assert drift[-1].accepted  # 17.5 deg from the first: eq. (67) compares with the one before


def test_pairings_that_alternate_are_never_accepted():
    flips = judge(2, [degrees(0, 90 + 180 * (k % 2)) for k in range(20)])
    assert not any(v.accepted for v in flips)


def test_a_common_sign_that_alternates_does_not_matter():
    flips = judge(3, [(-1) ** k * degrees(0, 90) for k in range(6)])
    assert flips[-1].accepted
    assert all((v.axes == degrees(0, 90)).all() for v in flips)


@pytest.mark.parametrize("local", [(0.5, 3.5), (3.5, 0.5), (3.0, 0.5)])
def test_both_axes_must_be_sure_and_the_bound_is_strict(local):
    assert not judge(1, [degrees(0, 90)] * 5, np.radians(local))[-1].accepted


# --- coverage ---


@pytest.mark.slow
@pytest.mark.parametrize("case", ["free motion, white noise", "planar motion, white noise"])
def test_regions_hold_the_truth_where_the_assumptions_hold(case):
    done = list(runs(CASES[case], 500))
    assert len(done) > 400
    for region in ("ellipsoid", "mu + 2 sigma of both axes"):
        held = np.mean([run.inside[f"Estimate.covariance: {region}"] for run in done])
        assert 0.90 <= held <= 0.99  # the requirement for 95 % regions


@pytest.mark.slow
def test_no_region_of_white_noise_holds_for_a_mount_that_leans():
    done = list(runs(CASES["a mount that leans by 3 deg rms"], 100))
    assert np.mean([run.inside["Estimate.covariance: ellipsoid"] for run in done]) < 0.5  # docs say so
