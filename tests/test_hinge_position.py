"""The joint centre from two IMUs, on closed-form rigs that share no code with the simulator."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks.hinge_rigs import HingeRig, random_rig
from imubench import rotations
from imubench.errors import InputError
from imubench.estimators import ESTIMATORS
from imubench.estimators.hinge_position import angular_acceleration, estimate, lever_matrices, residuals
from imubench.run import simulate

NOISE = 0.002, 0.02  # rad/s, m/s^2


def across(rig: HingeRig, value: np.ndarray) -> np.ndarray:
    """The error (6,) in m without its part along the hinge, which no hinge shows."""
    along = rig.axes.ravel() / np.sqrt(2)
    error = (value - rig.vectors).ravel()
    return error - along * (along @ error)


@pytest.mark.parametrize("seed", range(5))
def test_a_clean_rig_gives_the_joint_centre(seed):
    rig = random_rig(np.random.default_rng(seed))
    answer = estimate(rig.recording())
    assert answer.status == "converged"
    # The stencil errs by h^4 / 30 of the sixth derivative of angles of up to 1 Hz: 2e-5 rad/s^2 beside 10.
    assert np.abs(across(rig, answer.value)).max() < 2e-5
    j = rig.axes
    assert answer.value[0] @ j[0] + answer.value[1] @ j[1] == pytest.approx(0.0, abs=1e-5)


def test_the_jacobian_is_that_of_finite_differences():
    rig = random_rig(np.random.default_rng(0), count=50)
    w = np.stack([g[2:-2] for g in rig.gyro])
    levers = np.stack([lever_matrices(w[i], angular_acceleration(rig.gyro[i], 0.01)) for i in range(2)])
    accel = rig.accel[:, 2:-2]
    r = np.random.default_rng(1).normal(scale=0.1, size=6)
    _, slope = residuals(r, accel, levers)
    for k in range(6):
        step = np.eye(6)[k] * 1e-6
        difference = residuals(r + step, accel, levers)[0] - residuals(r - step, accel, levers)[0]
        assert_allclose(slope[:, k], difference / 2e-6, atol=1e-6)  # rounding 1e-15 * 20 / 1e-6, and step^2


def test_lever_matrices_are_the_cross_products():
    rng = np.random.default_rng(0)
    w, dw, r = rng.normal(size=(3, 20, 3))
    expected = np.cross(dw, r) + np.cross(w, np.cross(w, r))
    assert_allclose(np.einsum("nab,nb->na", lever_matrices(w, dw), r), expected, atol=1e-12)


def test_a_turned_sensor_turns_its_vector():
    rig = random_rig(np.random.default_rng(2))
    q = rotations.random(np.random.default_rng(3))
    turned = replace(
        rig,
        gyro=np.stack([rotations.rotate(q, rig.gyro[0]), rig.gyro[1]]),
        accel=np.stack([rotations.rotate(q, rig.accel[0]), rig.accel[1]]),
        mounts=np.stack([rotations.multiply(rig.mounts[0], rotations.conjugate(q)), rig.mounts[1]]),
    )
    one, two = estimate(rig.recording()), estimate(turned.recording())
    assert_allclose(two.value[0], rotations.rotate(q, one.value[0]), atol=1e-6)  # both converge to 1e-8 of a cost


def test_errors_are_as_large_as_claimed():
    squares = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        rig = random_rig(rng, amplitude=1.5)
        answer = estimate(rig.noisy(rng, *NOISE).recording())
        assert answer.covariance is not None
        error = across(rig, answer.value)
        values, vectors = np.linalg.eigh(answer.covariance)
        squares += list((vectors[:, :5].T @ error) ** 2 / values[:5])  # the sixth is the hinge's own direction
    # Noise of a differentiated signal is largest where motion is least: the claim is careful by a factor of up to 3.
    assert 0.2 < np.mean(squares) < 1.5


@pytest.mark.parametrize("name", ["hinge-locked", "hinge-planar", "hinge-swing"])
def test_what_a_motion_does_not_show_is_not_identified(name):
    answer = estimate(simulate(name, 0)[0])
    assert answer.status == "not identifiable"


def test_it_needs_two_imus_and_even_samples():
    rig = random_rig(np.random.default_rng(0), count=300)
    recording = rig.recording()
    with pytest.raises(InputError, match="expected two IMUs, got imu1"):
        estimate(replace(recording, imus=recording.imus[:1]))
    holes = np.cumsum(np.random.default_rng(0).uniform(0.005, 0.02, size=300))
    uneven = tuple(replace(imu, time=holes) for imu in recording.imus)
    with pytest.raises(InputError, match="evenly spaced samples"):
        estimate(replace(recording, imus=uneven))


def test_the_answer_is_well_formed():
    recording = random_rig(np.random.default_rng(0)).noisy(np.random.default_rng(1), *NOISE).recording()
    gyro = recording.imus[0].gyro.copy()
    answer = ESTIMATORS["hinge-position"].estimate(recording)
    assert (answer.estimator, answer.quantity, answer.status) == ("hinge-position", "joint_vector", "converged")
    assert answer.value.shape == (2, 3)
    assert answer.covariance is not None
    assert (np.linalg.eigvalsh(answer.covariance) > 0).all()
    assert np.array_equal(recording.imus[0].gyro, gyro)
