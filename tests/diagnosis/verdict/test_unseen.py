"""Which directions of an effect's numbers a recording does not show, and what these are called."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imubench.diagnosis.config.criteria import OBSERVABILITY
from imubench.diagnosis.directions import Directions, aligned, directions, in_words
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.refit import information, refit
from imubench.diagnosis.verdict.unobservable import named_axes, seen_of, unseen_in_words
from imubench.effects import EFFECTS
from imubench.errors import InputError
from imubench.sim import rigs
from imubench.sim.imu_model import Declared, DeclaredMount, observe
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.signals import hand

SECONDS = 8.0
WHITE = ImuProfile("white", 50.0, ChannelProfile(noise_std=0.004), ChannelProfile(noise_std=0.02))


def known(information_matrix, prior):
    """The covariance of numbers under a prior of these standard deviations."""
    return np.linalg.inv(information_matrix + np.diag(1 / np.asarray(prior) ** 2))


def test_what_no_sample_moves_is_not_seen_and_what_they_fix_is():
    prior = np.full(3, 0.15)
    found = directions(known(np.diag([1e6, 0.0, 1e4]), prior), prior)
    np.testing.assert_allclose(found.unseen, np.eye(3)[:, [1]], atol=1e-12)
    assert directions(known(np.eye(3) * 1e6, prior), prior).unseen.shape == (3, 0)
    assert directions(known(np.zeros((3, 3)), prior), prior).unseen.shape == (3, 3)


def test_the_line_is_half_the_prior_s_deviation():
    prior = np.array([2.0])
    for factor, seen in ((1.01, 1), (0.99, 0)):
        std = OBSERVABILITY.hidden * 2.0 * factor
        assert directions(np.array([[std**2]]), prior).unseen.shape[1] == seen
    # as the data alone would say, a std of the prior's over sqrt(3)
    data = np.array([[3 / 2.0**2]])
    assert known(data, prior)[0, 0] == pytest.approx((OBSERVABILITY.hidden * 2.0) ** 2)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(0, 6))
def test_the_unseen_space_is_found_whatever_its_basis(seed, k, m):
    rng = np.random.default_rng(seed)
    m = min(m, k)
    turn = np.linalg.qr(rng.normal(size=(k, k)))[0]
    blind, clear = turn[:, :m], turn[:, m:]
    prior = np.full(k, 0.3)
    found = directions(known(1e7 * clear @ clear.T, prior), prior)
    assert found.unseen.shape == (k, m)
    np.testing.assert_allclose(found.unseen.T @ found.unseen, np.eye(m), atol=1e-9)  # orthonormal to rounding
    np.testing.assert_allclose(found.unseen @ found.unseen.T, blind @ blind.T, atol=1e-5)  # 1e-7 of the information


def test_a_space_of_several_directions_is_told_by_its_axes():
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])
    basis = np.zeros((3, 2))
    basis[[0, 2]] = turn  # the plane of x and z
    np.testing.assert_allclose(np.sort(aligned(basis), axis=1), [[0, 1], [0, 0], [0, 1]], atol=1e-12)


def test_directions_are_named_or_told_in_numbers():
    axes = {"along the segment": np.eye(3)[0], "along the hinge axis": np.eye(3)[1]}
    y = np.eye(3)[:, [1]]
    assert in_words("translation", y, axes, "segment axes") == ("translation along the hinge axis",)
    oblique = np.array([[0.6], [0.0], [0.8]])
    assert in_words("translation", oblique, axes, "segment axes") == (
        "translation along (0.6, 0.0, 0.8) in segment axes",
    )
    assert in_words("damping_ratio", np.eye(3), {}, "") == ("damping ratio",)
    assert in_words("bias", np.zeros((3, 0)), {}, "") == ()


def test_directions_of_another_space_are_refused():
    with pytest.raises(InputError, match="expected as many rows as a covariance"):
        Directions(np.eye(3), np.zeros((2, 1)))
    with pytest.raises(InputError, match="finite"):
        Directions(np.full((1, 1), np.nan), np.zeros((1, 0)))


def hinge_fit(stds, seed=1):
    """The fit of a hinge so moved, its second sensor's mount in doubt."""
    rng = np.random.default_rng(seed)
    rig = rigs.hinge()
    tracks = {n: hand(rng, SECONDS, s, 1.0) for n, s in stds.items()}
    truth = play(rig, AngleMotion(**tracks), SECONDS, 500.0)
    mounts = {f"imu{i + 1}": DeclaredMount(m.position, m.quaternion, 1e-3, 5e-3) for i, m in enumerate(rig.mounts)}
    fit = nominal_fit(observe(truth, WHITE, rng, "moved", Declared(mounts)))
    h = Hypothesis(EFFECTS["mount_pose"], "imu2")
    return refit(fit, (*fit.model.hypotheses, h), steps=2), h


def test_no_motion_shows_how_far_a_sensor_is_turned_about_the_hinge_axis():
    """It reads what it would with another zero of the hinge angle, however it moves; all else is seen."""
    fit, h = hinge_fit({"heading": 0.8, "tilt": 0.4, "spin": 0.8, "angle": 0.7, "x": 0.1, "y": 0.1, "z": 0.05})
    found = seen_of(fit, h, information(fit)[0])
    assert unseen_in_words(fit, h, found) == ("rotation about the hinge axis",)
    assert set(found) == {"rotation", "translation"}


def test_the_hinge_axis_is_named_in_the_axes_of_a_sensor_that_is_turned():
    fit, h = hinge_fit({"spin": 0.8, "angle": 0.7})
    axes, frame = named_axes(fit, h, "rotation", 3)
    assert frame == "sensor axes"
    np.testing.assert_allclose(fit.model.mounts["imu2"].turn @ axes["about the hinge axis"], [0, 1, 0], atol=1e-12)
