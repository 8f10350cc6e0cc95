"""A recording below a frequency: what is left, where it is left out, and what it does to an estimate's covariance."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.hinge_rigs import random_rig
from imubench.band import EDGE, LowPass, banded, independent, runs
from imubench.errors import InputError
from imubench.recording import Imu, Recording
from imubench.run import estimate
from imubench.sim.signals import hand

RATE = 100.0  # Hz


def recording_of(time, signal, rate=RATE, **declared):
    """One IMU that reads the same signal (n,) on all of its axes."""
    columns = np.repeat(signal[:, None], 3, axis=1)
    return Recording("r", "free", (Imu("imu1", time, columns, 9.81 + columns, rate, **declared),))


def slow_and_fast(time):
    return np.sin(2 * np.pi * 1.0 * time), 0.5 * np.sin(2 * np.pi * 15.0 * time)


def test_what_is_below_the_band_stays_without_delay_and_what_is_above_goes():
    time = np.arange(1000) / RATE
    slow, fast = slow_and_fast(time)
    imu = banded(recording_of(time, slow + fast), 4.0).imus[0]
    kept = np.isin(time, imu.time)
    # of order 4, twice: 1 Hz below 4 Hz loses 1.5e-5 of its amplitude, 15 Hz keeps 4e-5; an end leaves two hundredths
    np.testing.assert_allclose(imu.gyro[:, 0], slow[kept], atol=0.02)
    np.testing.assert_allclose(imu.accel[:, 2], 9.81 + slow[kept], atol=0.02)
    middle = slice(100, -100)
    np.testing.assert_allclose(imu.gyro[middle, 0], slow[kept][middle], atol=1e-3)  # where the ends are far


def test_half_of_the_amplitude_is_left_at_the_band_itself():
    time = np.arange(4000) / RATE
    imu = banded(recording_of(time, np.sin(2 * np.pi * 3.0 * time)), 3.0).imus[0]
    # Butterworth: 1 / sqrt(2) a run, and it runs twice; 1 % for the finite piece
    assert np.sqrt(2) * imu.gyro[200:-200, 0].std() == pytest.approx(0.5, rel=0.01)


@pytest.mark.parametrize("hz", [1.0, 3.0, 8.0])
def test_samples_that_an_end_spoils_are_left_out(hz):
    """A piece cut out of a longer signal gives what the longer one gives, but at its very ends."""
    time = np.arange(6000) / RATE
    signal = hand(np.random.default_rng(0), 60.0, 1.0, 2.0)(time)[1]
    signal /= signal.std()
    whole = banded(recording_of(time, signal), hz).imus[0]
    part = banded(recording_of(time[2000:4000], signal[2000:4000]), hz).imus[0]
    assert part.time[0] == pytest.approx(20.0 + EDGE / hz, abs=1.0 / RATE)
    assert part.time[-1] == pytest.approx(39.99 - EDGE / hz, abs=1.5 / RATE)
    same = np.isin(whole.time, part.time)
    off = np.abs(whole.gyro[same, 0] - part.gyro[:, 0])
    assert off.max() < 0.2  # of a signal of std 1: exp(-2.4) of what a wrong continuation is off
    assert np.sqrt(np.mean(off**2)) < 0.03


def test_a_gap_is_an_end_on_either_side_and_a_lost_sample_is_none():
    time = np.delete(np.arange(3000) / RATE, [700, *range(1500, 1560)])
    slow, fast = slow_and_fast(time)
    assert [run.stop - run.start for run in runs(time, 1 / RATE)] == [1499, 1440]
    imu = banded(recording_of(time, slow + fast), 4.0).imus[0]
    edge = EDGE / 4.0
    assert not ((imu.time > 14.99 - edge + 1e-9) & (imu.time < 15.6 + edge - 1e-9)).any()
    assert np.isin([6.99, 7.01], imu.time).all()
    kept = np.isin(time, imu.time)
    np.testing.assert_allclose(imu.gyro[:, 0], slow[kept], atol=0.02)  # the spline across 15 Hz at the lost sample


def test_uneven_stamps_are_filtered_where_they_are():
    rng = np.random.default_rng(1)
    time = np.arange(2000) / RATE + rng.uniform(-0.003, 0.003, size=2000)
    slow, fast = slow_and_fast(time)
    imu = banded(recording_of(time, slow + fast), 4.0).imus[0]
    kept = np.isin(time, imu.time)  # its own stamps
    assert kept.sum() == imu.time.size > 1900
    off = np.abs(imu.gyro[:, 0] - slow[kept])
    # cubic splines through 15 Hz at 100 Hz are wrong by a few hundredths of it, of which 4 Hz keep some
    assert off.max() < 0.03
    taken_as_even = np.interp(time[kept], np.arange(2000) / RATE, slow)  # 3 ms of 6 rad/s would be 0.02 of noise
    assert np.sqrt(np.mean(off**2)) < 0.3 * np.sqrt(np.mean((taken_as_even - slow[kept]) ** 2)) + 0.005


@pytest.mark.parametrize("std", [0.01, None])
def test_noise_stds_become_those_of_the_filtered_samples(std):
    rng = np.random.default_rng(2)
    time = np.arange(20_000) / RATE
    noise = 0.01 * rng.normal(size=time.size)
    imu = banded(recording_of(time, noise, gyro_noise_std=std), 5.0).imus[0]
    # 20,000 samples, a tenth of them independent: 1.6 %; not declared, the tenth quietest second of pure noise
    # has four fifths to nine tenths of its std
    tolerance = 0.04 if std else 0.2
    assert imu.gyro_noise_std == pytest.approx(imu.gyro.std(), rel=tolerance)
    assert imu.gyro_noise_std == pytest.approx(0.01 * np.sqrt(LowPass(5.0, 1 / RATE).power), rel=tolerance)


@pytest.mark.parametrize(
    ("hz", "seconds", "message"),
    [
        (50.0, 10.0, r"imu1: expected a band below 50 Hz, half of the 100 samples a second, got 50 Hz"),
        (80.0, 10.0, r"imu1: expected a band below 50 Hz, half of the 100 samples a second, got 80 Hz"),
        (0.5, 5.0, r"imu1: expected 8 s without a gap for a band of 0.5 Hz, got at most 4.99 s"),
        (0.0, 5.0, r"band: expected a number > 0, got 0.0"),
        (-1.0, 5.0, r"band: expected a number > 0, got -1.0"),
        (np.nan, 5.0, r"band: expected a number > 0, got nan"),
    ],
)
def test_bands_that_a_recording_does_not_have(hz, seconds, message):
    time = np.arange(round(seconds * RATE)) / RATE
    with pytest.raises(InputError, match=f"^{message}$"):
        banded(recording_of(time, np.sin(time)), hz)


def test_everything_else_of_a_recording_stays():
    rig = random_rig(np.random.default_rng(3), 2000, RATE)
    recording = replace(rig.recording(), gravity=9.79, name="kept")
    found = banded(recording, 5.0)
    assert (found.name, found.gravity, found.rig) == ("kept", 9.79, "hinge")
    for before, after in zip(recording.imus, found.imus, strict=True):
        assert (after.name, after.rate) == (before.name, before.rate)
        np.testing.assert_array_equal(after.mount_quaternion, before.mount_quaternion)


def test_the_covariance_of_a_filtered_estimate_counts_independent_samples():
    """Error over stated sigma is near 1; taken for independent, 100 Hz below 5 Hz would state a third of it."""
    squares, naive = [], []
    clean = random_rig(np.random.default_rng(4), 2000, RATE, lever=0.0, amplitude=0.4)
    for run in range(30):
        noisy = clean.noisy(np.random.default_rng([4, run]), 0.01, 0.05).recording()
        answer = estimate("seel2012", noisy, band=8.0)
        errors = (answer.value - clean.axes).ravel()
        inverse = np.linalg.pinv(answer.covariance, rcond=1e-9, hermitian=True)
        squares.append(errors @ inverse @ errors / 4)
        naive.append(squares[-1] / answer.details["independent_samples"])
    # 30 runs of chi-square / 4 with 4 degrees of freedom: 1 +- 0.13; and what the filter itself does to fast motion
    assert 0.6 < np.mean(squares) < 1.5
    assert np.mean(naive) > 3.0


def test_independent_samples_are_twice_the_band_of_a_second():
    recording = recording_of(np.arange(100) / RATE, np.zeros(100))
    # a Butterworth run twice passes nine tenths of the power of an ideal filter
    assert independent(recording, 5.0) == pytest.approx(0.9 * 2 * 5.0 / RATE, rel=0.01)
