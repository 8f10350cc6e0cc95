"""Scores against hand-made cases and invariances."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from imubench import rotations
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.score import axis_deviation, maxae, rmsae, score, vector_error
from imubench.sim import rigs
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play

Y = np.array([0.0, 1.0, 0.0])


def tilted(degrees: float) -> np.ndarray:
    return rotations.rotate(rotations.exp(np.deg2rad([degrees, 0, 0])), Y)


def test_both_signs_turn_together():
    deviations = axis_deviation([-tilted(3), -tilted(5)], [Y, Y])
    assert_allclose(np.rad2deg(deviations), [3, 5], atol=1e-9)


def test_wrong_sign_pairing_shows_on_the_second_axis():
    assert_allclose(np.rad2deg(axis_deviation([tilted(3), -tilted(5)], [Y, Y])), [3, 175], atol=1e-9)
    assert_allclose(np.rad2deg(axis_deviation([-tilted(3), tilted(5)], [Y, Y])), [3, 175], atol=1e-9)


def test_many_pairs_at_once():
    pairs = np.array([[tilted(a), tilted(2 * a)] for a in (1, 2, 3)])
    assert_allclose(np.rad2deg(axis_deviation(pairs, [Y, Y])), [[1, 2], [2, 4], [3, 6]], atol=1e-9)


def test_rmsae_and_maxae():
    assert rmsae([[0.0, 0.0], [3.0, 5.0]]) == pytest.approx(np.sqrt(34 / 4))
    assert maxae([[0.1, 0.2], [0.3, 0.05]]) == 0.3


def test_vector_error_has_three_parts():
    error, length, angle = vector_error([0.0, 0.0, 0.21], [0.0, 0.2, 0.0])
    assert_allclose([error, length, angle], [np.hypot(0.21, 0.2), 0.01, np.pi / 2])


@given(st.integers(0, 2**32 - 1))
def test_deviation_does_not_depend_on_the_sensor_frames(seed):
    rng = np.random.default_rng(seed)
    true, found = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in rng.normal(size=(2, 2, 3)))
    q = rotations.random(rng, 2)
    assert_allclose(
        axis_deviation(rotations.rotate(q, found), rotations.rotate(q, true)), axis_deviation(found, true), atol=1e-7
    )  # near 0 and pi the sign rule and arctan2 lose half the digits


def axis_estimate(value: np.ndarray) -> Estimate:
    return Estimate("joint_axis", "test", value, None, "a test needs none")


def test_score_of_an_axis_judges_by_the_truth():
    rig = rigs.random_hinge(np.random.default_rng(0))
    truth = play(rig, AngleMotion(), 0.1)
    true = np.stack([rotations.rotate_back(m.quaternion, Y) for m in rig.mounts])
    perfect = score(axis_estimate(true), truth)
    assert perfect.figures["maxae"] < 1e-9
    assert perfect.units["deviation_imu1"] == "rad"
    with pytest.raises(InputError, match="hinge and two IMUs"):
        score(axis_estimate(true), play(rigs.pendulum(), AngleMotion(), 0.1))


def test_score_of_a_vector_follows_a_moving_sensor():
    truth = play(rigs.pendulum(), AngleMotion(), 0.1)
    r = np.array([[-0.06, 0.02, 0.2]])
    constant = score(Estimate("joint_vector", "test", r, None, "none"), truth)
    assert constant.figures["error_imu1"] < 1e-9
    per_sample = Estimate(
        "joint_vector", "test", np.tile(r + np.array([0.003, 0, 0]), (9, 1, 1)), None, "none", time=np.arange(9) / 100
    )
    assert score(per_sample, truth).figures["error_imu1"] == pytest.approx(0.003)


def test_an_estimate_needs_a_covariance_or_a_reason():
    with pytest.raises(InputError, match="covariance or a reason"):
        Estimate("joint_axis", "test", np.stack([Y, Y]), None)
    with pytest.raises(InputError, match="unit vectors"):
        axis_estimate(np.ones((2, 3)))
