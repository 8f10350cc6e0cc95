"""Gradient descent after Frick and Rahmatalla: the local parabola, the step, one sample at a time, the pendulum."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import savgol_filter

from benchmarks.pendulum_runs import R_MEAN, R_VARIES, RATE, circling
from imubench.errors import InputError
from imubench.estimators import frick_rahmatalla, mrvs
from imubench.estimators.frick_rahmatalla import HALF, FrickRahmatalla, descend, follow, smooth
from imubench.recording import Imu, Recording
from imubench.score import vector_error


def test_a_parabola_passes_whatever_the_stamps():
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.005, 0.015, size=40))
    c = rng.normal(size=(3, 3))
    value, slope = smooth(c[0] + c[1] * time[:, None] + c[2] * time[:, None] ** 2, time)
    t = time[HALF:-HALF, None]
    assert_allclose(value, c[0] + c[1] * t + c[2] * t**2, atol=1e-10)  # rounding times the condition of a window
    assert_allclose(slope, c[1] + 2 * c[2] * t, atol=1e-9)  # the same over 0.01 s


def test_even_stamps_make_it_the_filter_of_savitzky_and_golay():
    x = np.random.default_rng(1).normal(size=(2, 50, 3))
    value, slope = smooth(x, np.arange(50) / RATE, 3)
    inner = slice(3, 47)
    assert_allclose(value, savgol_filter(x, 7, 2, axis=1)[:, inner], atol=1e-12)  # rounding
    assert_allclose(slope, savgol_filter(x, 7, 2, deriv=1, delta=0.01, axis=1)[:, inner], atol=1e-10)


def test_a_step_goes_down_the_gradient_to_the_lowest_point():
    rng = np.random.default_rng(2)
    M, a, r = rng.normal(size=(3, 3)), rng.normal(size=3), rng.normal(size=3)

    def cost(x):
        return np.sum((a + M @ x) ** 2) / 2

    h = 1e-6
    gradient = np.array([(cost(r + e) - cost(r - e)) / (2 * h) for e in h * np.eye(3)])
    step = descend(M, a, r, 1) - r
    assert_allclose(step / np.linalg.norm(step), -gradient / np.linalg.norm(gradient), atol=1e-8)  # rounding over h
    along = [cost(r + scale * step) for scale in (0.99, 1.0, 1.01)]
    assert np.argmin(along) == 1
    assert_allclose(descend(M, a, r, 2000), -np.linalg.solve(M, a), atol=1e-6)  # slowly, as steepest descent is


def test_nothing_to_descend_is_no_step():
    r = np.array([[0.1, 0.2, 0.3]])
    assert (descend(np.zeros((1, 3, 3)), np.zeros((1, 3)), r) == r).all()


def test_one_at_a_time_gives_the_same_numbers():
    rng = np.random.default_rng(3)
    runs = circling(rng, amplitude=R_VARIES, duration=2.0)
    time = runs.time + rng.uniform(-0.002, 0.002, size=runs.time.size)
    stream = FrickRahmatalla(R_MEAN)
    steps = np.diff(time, prepend=time[0]).tolist()
    samples = zip(runs.gyro[0], runs.acceleration[0], steps, strict=True)
    streamed = np.array([stream.update(w, a, dt) for w, a, dt in samples])
    assert np.isnan(streamed[: 2 * HALF]).all()
    together = follow(runs.gyro, runs.acceleration, time, R_MEAN)[0]
    assert_allclose(streamed[2 * HALF :], together, atol=1e-9)  # rounding; stamps summed up anew


def inner_errors(runs, **options):
    r = follow(runs.gyro, runs.acceleration, runs.time, **options)
    return vector_error(r, runs.r[HALF:-HALF])[0]


def test_without_noise_a_constant_r_stays_where_least_squares_puts_it():
    runs = circling(np.random.default_rng(4), noise=(0.0, 0.0))
    w, dw = smooth(runs.gyro, runs.time)
    r0, _ = mrvs.solve(w, dw, smooth(runs.acceleration, runs.time)[0])
    # a parabola over 9 samples of a sine of 1 Hz takes 0.8 % off its slope, r comes out longer by that: 1.6 mm of 210
    assert np.linalg.norm(r0 - R_MEAN) < 0.0025
    assert inner_errors(runs).max() < 0.005


def test_a_varying_r_is_followed_as_closely_as_the_table_has_it_for_arve_d():
    runs = circling(np.random.default_rng(5), count=10, amplitude=R_VARIES)
    errors = inner_errors(runs)
    assert errors.mean() < 0.0055  # table I has 6.8 mm for ArVE_d; 4.7 measured, 10 runs scatter by 0.13
    whole = vector_error(mrvs.solve_differenced(runs.gyro, runs.acceleration, runs.time)[0][:, None], runs.r)[0]
    assert errors.mean() < whole.mean() / 2


def test_from_zeros_it_finds_its_way_within_one_second():
    runs = circling(np.random.default_rng(6), count=10)
    errors = inner_errors(runs, r0=np.zeros(3))
    assert errors[:, 100:].mean() < 1.05 * inner_errors(runs)[:, 100:].mean()  # the start is forgotten


def test_a_recording():
    runs = circling(np.random.default_rng(7), amplitude=R_VARIES)
    answer = frick_rahmatalla.estimate(runs.recording(pose=True), "pose")
    assert (answer.estimator, answer.quantity, answer.status) == ("frick-rahmatalla", "joint_vector", "converged")
    assert_allclose(answer.value[:, 0], follow(runs.gyro, runs.acceleration, runs.time)[0], atol=1e-9)  # gravity
    assert_allclose(answer.time, runs.time[HALF:-HALF])
    assert answer.covariance is None
    assert "lag behind" in answer.no_covariance_because


def test_motion_without_information_is_called_so():
    rng = np.random.default_rng(8)
    gyro = 0.0017 * rng.normal(size=(300, 3))
    accel = np.tile([0, 0, 9.81], (300, 1)) + 0.02 * rng.normal(size=(300, 3))
    recording = Recording("still", "pendulum", (Imu("imu1", np.arange(300) / RATE, gyro, accel, RATE, 0.0017, 0.02),))
    answer = frick_rahmatalla.estimate(recording)
    assert answer.status == "not identifiable"
    assert "turned too little" in answer.no_covariance_because


def test_bad_input():
    runs = circling(np.random.default_rng(9), duration=0.08)
    with pytest.raises(InputError, match="run: frick-rahmatalla expected 9 samples or more, got 8"):
        frick_rahmatalla.estimate(runs.recording())
    with pytest.raises(InputError, match="frick-rahmatalla: expected half and steps of 1 or more, got 0 and 3"):
        FrickRahmatalla(np.zeros(3), half=0)
    stream = FrickRahmatalla(np.zeros(3))
    stream.update(np.zeros(3), np.zeros(3), 0.01)
    with pytest.raises(InputError, match=r"frick-rahmatalla: expected a time step > 0 s, got 0.0"):
        stream.update(np.zeros(3), np.zeros(3), 0.0)
    with pytest.raises(InputError, match="gyro"):
        stream.update(np.full(3, np.nan), np.zeros(3), 0.01)
