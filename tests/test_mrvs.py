"""MrVS: the matrix of eq. (6), one r for a record, one for a window."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks.pendulum_runs import GRAVITY, R_MEAN, R_VARIES, RATE, circling
from imubench.errors import InputError
from imubench.estimators import mrvs
from imubench.estimators.centre_ekf import expected_acceleration
from imubench.recording import Imu, Recording
from imubench.scenarios.pendulum import ellipse, limb
from imubench.score import vector_error
from imubench.sim.play import play


def test_the_pendulum_of_these_tests_is_that_of_the_simulator():
    runs = circling(np.random.default_rng(0), amplitude=R_VARIES, noise=(0.0, 0.0))
    sensor = play(limb("paper"), ellipse(), 10.0, RATE).sensors[0]
    for ours, theirs in (
        (runs.gyro[0], sensor.gyro),
        (runs.accel[0], sensor.specific_force),
        (runs.angular_acceleration, sensor.angular_acceleration),
        (runs.r, sensor.joint_vector),
    ):
        assert_allclose(ours, theirs, atol=1e-9)  # two derivations of one motion, both in closed form


def test_the_matrix_is_that_of_equation_6():
    wx, wy, wz, ax, ay, az = np.random.default_rng(1).normal(size=6)
    printed = [
        [-wy * wy - wz * wz, -az + wx * wy, ay + wx * wz],
        [az + wx * wy, -wx * wx - wz * wz, -ax + wy * wz],
        [-ay + wx * wz, ax + wy * wz, -wx * wx - wy * wy],
    ]
    assert_allclose(mrvs.lever_matrix([wx, wy, wz], [ax, ay, az]), printed, atol=1e-15)  # rounding


def test_the_sign_is_that_of_a_centrifuge():
    # A sensor at +0.5 m along x from the joint, turning about z at 2 rad/s and speeding up by 3 rad/s^2: it is pulled
    # towards the joint by w^2 l = 2 m/s^2 and along +y by w' l = 1.5 m/s^2. From the sensor the joint lies along -x.
    acceleration = np.array([-2.0, 1.5, 0.0])
    r, w, dw = np.array([-0.5, 0.0, 0.0]), np.array([0.0, 0.0, 2.0]), np.array([0.0, 0.0, 3.0])
    assert_allclose(expected_acceleration(r, w, dw), acceleration, atol=1e-15)  # rounding
    assert_allclose(mrvs.lever_matrix(w, dw) @ r, -acceleration, atol=1e-15)


def test_constant_r_without_noise_and_with_exact_angular_acceleration():
    runs = circling(np.random.default_rng(0), noise=(0.0, 0.0))
    r, covariance = mrvs.solve(runs.rate, runs.angular_acceleration, runs.acceleration[0])
    assert_allclose(r, R_MEAN, atol=1e-9)  # rounding; 1e-4 is asked for
    assert np.sqrt(np.trace(covariance)) < 1e-7  # rounding in the sum of squares, square root of 1e-16


def test_central_differences_cost_what_their_attenuation_says():
    runs = circling(np.random.default_rng(0), noise=(0.0, 0.0))
    r, _ = mrvs.solve_differenced(runs.gyro[0], runs.acceleration[0], runs.time)
    # sin(x) / x of x = 2 pi / 100: w' comes out 0.066 % too small, r so much too large, 0.14 mm of 210
    assert 0.0001 < np.linalg.norm(r) - np.linalg.norm(R_MEAN) < 0.00018
    assert np.linalg.norm(r - R_MEAN) < 0.0002


def test_it_knows_the_scatter_of_white_noise():
    runs = circling(np.random.default_rng(2), count=200, noise=(0.0, 0.02))
    r, covariance = mrvs.solve(runs.rate, runs.angular_acceleration, runs.acceleration)
    error = r - R_MEAN
    squares = np.einsum("ri,rij,rj->r", error, np.linalg.inv(covariance), error) / 3
    assert 0.77 < squares.mean() < 1.23  # 200 runs of chi-square / 3: 1 +- 0.058, four of these


def test_windows_are_what_they_are_one_by_one():
    runs = circling(np.random.default_rng(3), count=2, amplitude=R_VARIES, duration=3.0)
    w, dw, a = runs.gyro, np.broadcast_to(runs.angular_acceleration, runs.gyro.shape), runs.acceleration
    r, covariance = mrvs.sums(w, dw, a, window=45).solve()
    assert r.shape == (2, 256, 3)
    for k in (0, 100, 255):
        part = slice(k, k + 45)
        alone, scatter = mrvs.solve(w[:, part], dw[:, part], a[:, part])
        assert_allclose(r[:, k], alone, atol=1e-10)  # differences of running sums, rounding times condition
        assert_allclose(covariance[:, k], scatter, rtol=1e-6)


def test_a_stream_gives_the_same_windows():
    runs = circling(np.random.default_rng(4), amplitude=R_VARIES, duration=2.0)
    stream = mrvs.WindowMrvs(45)
    samples = zip(runs.gyro[0], runs.acceleration[0], runs.time.tolist(), strict=True)
    streamed = np.array([stream.update(w, a, t) for w, a, t in samples])
    r, _ = mrvs.solve_windows(runs.gyro[0], runs.acceleration[0], runs.time, 45)
    assert np.isnan(streamed[:46]).all()
    assert_allclose(streamed[46:], r, atol=1e-10)  # as above


def test_no_rank_no_number():
    still = np.zeros((50, 3))
    r, covariance = mrvs.solve(still, still, np.tile([0, 0, 0.01], (50, 1)))
    assert np.isnan(r).all()
    assert np.isnan(covariance).all()
    spin = np.tile([0.0, 0.0, 2.0], (50, 1))  # about one axis: nothing along it
    assert np.isnan(mrvs.solve(spin, still, np.tile([-2.0, 0.0, 0.0], (50, 1)))[0]).all()


def test_no_constant_is_nearer_to_a_varying_r_than_the_papers_own_amplitudes_allow():
    runs = circling(np.random.default_rng(5), count=10, amplitude=R_VARIES)
    r, _ = mrvs.solve_differenced(runs.gyro, runs.acceleration, runs.time)
    error = vector_error(r[:, None], runs.r)[0].mean()
    # r runs along a line and back: the mean is the best constant, 2/pi of |(20, 5, 20)| = 18.3 mm away on average
    assert error >= 2 / np.pi * np.linalg.norm(R_VARIES) - 1e-5
    assert error < 0.0185


# --- recordings ---


def test_a_recording_with_a_pose():
    answer = mrvs.estimate(circling(np.random.default_rng(6)).recording(pose=True), "pose")
    assert (answer.estimator, answer.quantity, answer.status) == ("mrvs", "joint_vector", "converged")
    assert_allclose(answer.value, R_MEAN[None], atol=0.0005)  # 0.2 mm measured
    assert answer.covariance.shape == (3, 3)


def test_a_recording_in_windows():
    runs = circling(np.random.default_rng(7), amplitude=R_VARIES)
    answer = mrvs.estimate_window(runs.recording(pose=True), "pose", window=45)
    r, covariance = mrvs.solve_windows(runs.gyro[0], runs.acceleration[0], runs.time, 45)
    assert_allclose(answer.value[:, 0], r, atol=1e-9)  # gravity taken out and put back
    assert_allclose(answer.time, runs.time[46:])
    assert answer.covariance.shape == covariance.shape


@pytest.mark.parametrize("estimate", [mrvs.estimate, mrvs.estimate_window])
@pytest.mark.parametrize("declared", [True, False])
@pytest.mark.parametrize("about", ["nothing", "one axis"])
def test_motion_without_information_is_called_so(estimate, declared, about):
    rng = np.random.default_rng(8)
    time = np.arange(500) / RATE
    swing = 3.0 * np.sin(6 * time)[:, None] * [0, 0, 1.0] if about == "one axis" else np.zeros((500, 3))
    gyro = swing + 0.0017 * rng.normal(size=(500, 3))
    accel = np.tile([0, 0, GRAVITY], (500, 1)) + 0.02 * rng.normal(size=(500, 3))
    imu = Imu("imu1", time, gyro, accel, RATE, 0.0017 if declared else None)
    answer = estimate(Recording("still", "pendulum", (imu,)))
    assert answer.status == "not identifiable"
    assert answer.covariance is None
    assert "turned too little" in answer.no_covariance_because


def test_undeclared_gyroscope_noise_is_found_in_the_samples():
    runs = circling(np.random.default_rng(9))
    assert mrvs.gyro_noise(runs.gyro[0]) == pytest.approx(0.0017, rel=0.1)  # 3000 correlated differences: 3 % once


def test_bad_input():
    runs = circling(np.random.default_rng(0), duration=0.3)
    with pytest.raises(InputError, match="window: expected 1 to 30 samples, got 31"):
        mrvs.sums(runs.gyro, runs.gyro, runs.acceleration, window=31)
    with pytest.raises(InputError, match="window: expected 1 sample or more, got 0"):
        mrvs.WindowMrvs(0)
    with pytest.raises(InputError, match="run: mrvs-window expected 47 samples or more, got 30"):
        mrvs.estimate_window(runs.recording())
    imu = runs.recording().imus[0]
    two = Recording("pair", "hinge", (imu, Imu("imu2", imu.time, imu.gyro, imu.accel, RATE)))
    with pytest.raises(InputError, match="pair: mrvs expected one IMU on a limb whose joint rests, got imu1, imu2"):
        mrvs.estimate(two)
