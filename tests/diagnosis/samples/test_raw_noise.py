"""A hum and louder noise are found in the raw samples, with their sizes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from imubench.diagnosis.samples.even_grid import stretches
from imubench.diagnosis.samples.noise_floor import white_level
from tests.raw_signals import ACCEL, GYRO, effects, found, humming, imu


@pytest.mark.parametrize(
    ("rate", "frequency"), [(50.0, 19.3), (100.0, 15.2), (100.0, 41.7), (200.0, 77.0), (100.0, 130.0)]
)
@pytest.mark.parametrize("size", [0.03, 0.5])
def test_a_hum_is_found_with_its_frequency_and_amplitude(rate, frequency, size):
    amplitude = size * np.array([0.8, -0.6, 0.0])
    finding = found(imu(51, rate=rate, before=humming(amplitude, frequency)), "vibration")
    image = abs(frequency - rate * round(frequency / rate))
    value, std, _ = finding.parameters["frequency"]
    assert abs(value - image) < max(4 * std, 0.03)  # a tenth of the windows' resolution
    size_found = finding.parameters["amplitude"][0]
    error = min(np.linalg.norm(size_found - amplitude), np.linalg.norm(size_found + amplitude))
    assert error < 0.1 * size + 0.006  # noise of 0.02 in 100 samples: 0.003 for each of cosine and sine


def test_a_hum_is_found_where_lost_samples_leave_three_windows():
    whole = imu(51, seconds=14.4, before=humming(np.array([0.3, -0.2, 0.5]), 22.0))
    keep = (np.abs(whole.time - 5.0) > 0.05) & (np.abs(whole.time - 9.5) > 0.05)  # one window of 4 s in each piece
    short = replace(whole, time=whole.time[:850], gyro=whole.gyro[:850], accel=whole.accel[:850])
    broken = replace(whole, time=whole.time[keep], gyro=whole.gyro[keep], accel=whole.accel[keep])
    for recording in (short, broken):
        assert abs(found(recording, "vibration").parameters["frequency"][0] - 22.0) < 0.05


def test_three_windows_of_noise_have_no_hum():
    rng = np.random.default_rng(7)
    for seed in range(40):
        whole = imu(seed, seconds=9.0, colour=0.2 * rng.random())
        keep = rng.random(whole.time.size) > 0.3 * (seed % 2)
        kept = replace(whole, time=whole.time[keep], gyro=whole.gyro[keep], accel=whole.accel[keep])
        assert "vibration" not in effects(kept)


def test_a_hum_above_a_slow_motion_is_found_and_a_hand_that_shakes_is_none():
    slow = imu(53, band=1.0, rate_rms=0.5, accel_rms=0.5, before=humming(np.array([0.3, 0, 0]), 8.5))
    assert abs(found(slow, "vibration").parameters["frequency"][0] - 8.5) < 0.03

    def shaking(rng, t, gyro, accel):
        turn, rate = 0.05 * np.sin(2 * np.pi * 9.0 * t), 0.05 * 2 * np.pi * 9.0 * np.cos(2 * np.pi * 9.0 * t)
        force = [-9.81 * np.sin(turn) - 0.2 * rate**2, 0 * t, 9.81 * np.cos(turn) - 0.2 * (18 * np.pi) ** 2 * turn]
        return np.stack([0 * t, rate, 0 * t], axis=1), np.stack(force, axis=1)  # a line at 9 Hz, and one at 18

    assert effects(imu(54, before=shaking)) == set()


def test_a_resonance_is_no_hum():
    """A mount at 14 Hz, damped by 0.1, that the motion and tremor shake."""

    def rocking(rng, t, gyro, accel):
        w, z, dt = 2 * np.pi * 14.0, 0.1, t[1]
        r = np.exp(-z * w * dt)
        shaken = lfilter(
            [1], [1, -2 * r * np.cos(w * dt * np.sqrt(1 - z**2)), r**2], rng.normal(size=accel.shape), axis=0
        )
        return gyro, accel + 0.3 * shaken / shaken.std()

    assert "vibration" not in effects(imu(52, before=rocking))


@pytest.mark.parametrize("factor", [1.5, 2.5, 5.0])
@pytest.mark.parametrize("part", ["gyro", "accel"])
def test_noise_above_the_declared_is_found_with_its_level(part, factor):
    std = {"gyro": GYRO, "accel": ACCEL}

    def louder(rng, t, gyro, accel):
        extra = np.sqrt(factor**2 - 1) * std[part]
        both = {"gyro": gyro, "accel": accel}
        both[part] = both[part] + extra * rng.normal(size=gyro.shape)
        return t, both["gyro"], both["accel"]

    finding = found(imu(61, colour=0.2, after=louder), f"{part}_noise")
    value, error, _ = finding.parameters["std"]
    # the coloured noise's tail above 12 Hz adds up to 2 % of power to the usual level
    assert abs(value - factor * std[part]) < 4 * error + 0.02 * std[part]


def test_the_noise_levels_error_is_what_it_says():
    z = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        time, none = np.arange(2000) / 100, np.zeros(2000, dtype=bool)
        pieces = stretches(time, rng.normal(size=(2000, 3)), rng.normal(size=(2000, 3)), none)
        level = white_level(pieces, "gyro", 100.0, none)
        z.append((level.std - 1) / level.error)
    assert 0.7 < np.sqrt(np.mean(np.square(z))) < 1.3  # forty draws: 11 % of error, and a tenth for the formula


def test_rattling_that_comes_and_goes_is_no_noise():
    """A dead band or play is rough in motion and quiet at rest; a sensor's noise is there all the time."""

    def rattle(rng, t, gyro, accel):
        moving = np.abs(np.sin(0.2 * t))[:, None] ** 2
        return gyro + 0.02 * moving * rng.normal(size=gyro.shape), accel

    assert effects(imu(63, before=rattle)) == set()


def test_fast_motion_is_no_noise():
    """Motion that fades slowly towards the highest frequencies, as a hand's real motion does at 40 Hz."""

    def tremor(rng, t, gyro, accel):
        slow = lfilter([0.2], [1, -0.8], rng.normal(size=gyro.shape), axis=0)
        return gyro + 0.05 * lfilter([0.2], [1, -0.8], slow, axis=0), accel + 0.5 * lfilter(
            [0.2], [1, -0.8], slow, axis=0
        )

    assert effects(imu(62, rate=50.0, rest=0.0, before=tremor)) == set()
