"""An r that slides or hangs on a spring: recovery in batch and on a stream, and what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import chi2

from imubench.errors import InputError
from imubench.estimators import sliding, sliding_search
from imubench.estimators.centre_ekf import covariances_of
from imubench.estimators.centre_runs import track
from imubench.estimators.sliding import SlidingStream, answer, best
from imubench.recording import Imu, Recording
from tests.swinging_limb import BIG, NOISE, RATE, G, recorded, slide, sprung

# --- recovery ---


def mean_error(fit, rows, r):
    return np.linalg.norm(answer(fit, rows.time)[0] - r, axis=1).mean()


def test_a_constant_stays_constant():
    rows, r = recorded(lambda t: slide(t), seed=0)
    fit = best(rows)
    a = track(rows.gyro[None], rows.acceleration[None], rows.time, 12, covariances_of("arve-d", "constant"))
    filtered = np.linalg.norm(a.r[0] - r[a.first :], axis=1).mean()
    assert fit.name == "constant"
    assert mean_error(fit, rows, r) < 1.2 * filtered  # asked for; 0.2 to 0.5 mm


def test_without_noise_a_constant_is_exact():
    rows, r = recorded(lambda t: slide(t), noise=(1e-5, 1e-4))
    assert mean_error(best(rows), rows, r) < 1e-4  # m


@pytest.mark.parametrize("frequency", [0.3, 1.0, 2 / 3, 2.7])
@pytest.mark.parametrize("phase", [0.0, 1.5])
def test_a_slide_of_unknown_frequency(frequency, phase):
    rows, r = recorded(lambda t: slide(t, (BIG[0], frequency, phase)), seed=1)
    fit = best(rows)
    assert fit.name == "felt"
    assert_allclose(fit.frequency, [frequency], atol=0.003)  # Hz; a 30th of one over the record
    assert mean_error(fit, rows, r) < 0.0015  # m; asked for are 5 mm, 0.2 to 0.9 are reached


def test_two_slides_at_once():
    rows, r = recorded(lambda t: slide(t, BIG, ([0.004, -0.006, 0.003], 2.6, 1.0)), seed=2)
    fit = best(rows)
    assert_allclose(np.sort(fit.frequency), [1.0, 2.6], atol=0.01)
    assert mean_error(fit, rows, r) < 0.002


@pytest.mark.parametrize("frequency", [0.3, 1.0, 4.0])
def test_a_slide_that_is_not_felt(frequency):
    rows, r = recorded(lambda t: slide(t, (BIG[0], frequency, 0.5)), felt=False, seed=3)
    fit = best(rows)
    assert fit.name == "unfelt"
    assert mean_error(fit, rows, r) < 0.0015


@pytest.mark.parametrize(("frequency", "damping"), [(6.0, 0.2), (3.7, 0.2), (3.0, 0.05), (3.7, 0.6)])
def test_a_spring(frequency, damping):
    rows, r = sprung(frequency, damping, seed=4)
    fit = best(rows)
    assert fit.name == "spring"
    assert fit.frequency == pytest.approx((frequency,) * 3, rel=0.08)  # three sigma of the stiffest
    assert mean_error(fit, rows, r) < 0.0015  # m; asked for are 5 mm


def test_the_covariance_is_right_where_its_model_is():
    squares = []
    for seed in range(24):
        rows, r = recorded(lambda t: slide(t, (BIG[0], 0.7, 0.2)), seed=100 + seed)
        value, covariance = answer(sliding_search.fit(rows, True), rows.time)
        e = value[500] - r[500]
        squares.append(e @ np.linalg.solve(covariance[500], e))
    low, high = chi2.ppf([0.001, 0.999], 3 * 24)
    assert low < np.sum(squares) < high


def recording_of(rows):
    imu = Imu("imu1", rows.time, rows.gyro, rows.accel, RATE, *NOISE)
    return Recording("limb", "pendulum", (imu,))


def test_what_an_orientation_filter_leaves_of_gravity_is_fitted_along():
    rows, r = recorded(lambda t: slide(t, BIG), seed=7)
    found = sliding.estimate(recording_of(rows), "ukf")  # which takes the first, moving, sample for up: 0.2 rad
    assert np.linalg.norm(found.value[:, 0] - r, axis=1).mean() < 0.0015  # m; as with a known orientation
    assert found.covariance is not None
    assert found.details["residual_power"] == pytest.approx(1.0, abs=0.15)  # 741 rows: 0.05 is one sigma


def test_an_r_that_no_kind_explains_has_no_covariance():
    rng = np.random.default_rng(0)
    parts = [(0.004 * rng.normal(size=3), f, rng.uniform(0, 6)) for f in rng.uniform(0.3, 3, size=16)]
    rows, _ = recorded(lambda t: slide(t, *parts), seed=8)
    found = sliding.estimate(recording_of(rows))
    assert found.covariance is None
    assert "no kind of r explains the samples" in found.no_covariance_because


# --- on a stream ---


def streamed(rows):
    stream = SlidingStream(*NOISE)
    return np.array(
        [stream.update(*x, 0.01) for x in zip(rows.gyro, rows.accel, rows.accel - rows.up, strict=True)]
    ), stream


@pytest.mark.parametrize("kind", ["constant", "felt", "unfelt", "spring"])
def test_a_stream_converges(kind):
    if kind == "spring":
        rows, r = sprung(3.7, 0.2, seed=5, duration=6.0)
    else:
        parts = () if kind == "constant" else (BIG,)
        rows, r = recorded(lambda t: slide(t, *parts), kind == "felt", seed=5, duration=6.0)
    found, stream = streamed(rows)
    assert np.isnan(found[:200]).all()
    assert np.isfinite(found[200:]).all()
    errors = np.linalg.norm(found - r, axis=1)[400:]
    assert stream.fit.name == kind
    assert errors.mean() < 0.003  # m; asked for are 10 mm, 2 s after the first answer 0.2 to 2 are reached
    assert np.linalg.eigvalsh(stream.covariance).min() > 0


def test_a_stream_refuses_a_time_that_stands():
    stream = SlidingStream()
    stream.update(np.zeros(3), G, np.zeros(3), 0.0)
    with pytest.raises(InputError, match=r"sliding-stream: expected a time step > 0 s, got 0\.0"):
        stream.update(np.zeros(3), G, np.zeros(3), 0.0)


# --- what is refused ---


def test_samples_that_are_not_even_are_refused():
    t = np.arange(100) / RATE
    t[50:] += 0.03
    rate = np.random.default_rng(0).standard_normal((100, 3))
    imu = Imu("imu1", t, rate, np.tile(G, (100, 1)), RATE, *NOISE)
    with pytest.raises(InputError, match=r"sliding: expected samples 0.01 s apart, got 0.04 s before row 50"):
        sliding.estimate(Recording("r", "pendulum", (imu,)))


def test_too_few_samples_are_refused():
    t = np.arange(30) / RATE
    imu = Imu("imu1", t, np.zeros((30, 3)), np.tile(G, (30, 1)), RATE, *NOISE)
    recording = Recording("r", "pendulum", (imu,))
    assert sliding.estimate(recording).status == "not identifiable"
    with pytest.raises(InputError, match=r"r: sliding-stream expected 2 s or more, got 0.29 s"):
        sliding.estimate_stream(recording)
