"""A hum that turns the sensor too is taken out of its samples; one of the accelerometer alone is made steady."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.config.samples import NOTCH
from imubench.diagnosis.samples.notch import (
    sidebands,
    steady,
    turns_with_hum,
    with_steady_hum,
    without_further_hums,
    without_hum,
)
from imubench.recording import Imu

RATE, SECONDS, HUM = 250.0, 20.0, 45.0


def shaken(gyro_hum, seed=0):
    """A hand's motion below 3 Hz with a hum that wanders, 0.5 m/s^2 and `gyro_hum` rad/s; and the motion alone."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, SECONDS, 1 / RATE)
    slow = np.stack([np.sin(2 * np.pi * f * time) for f in (0.7, 1.6, 2.9)], axis=1)
    phase = 2 * np.pi * HUM * time + np.cumsum(0.05 * rng.standard_normal(time.size))
    line = np.sin(phase)[:, None] * np.array([1.0, 0.5, 0.2])
    noise = rng.standard_normal((2, time.size, 3)) * np.array([0.002, 0.02])[:, None, None]
    still = Imu("imu1", time, slow + noise[0], 5 * slow + noise[1], RATE)
    return replace(still, gyro=still.gyro + gyro_hum * line, accel=still.accel + 0.5 * line), still


def none(imu):
    return np.zeros(imu.time.size, dtype=bool)


@pytest.mark.parametrize("seed", range(3))
def test_a_hum_turns_the_sensor_where_the_gyroscope_hears_it(seed):
    for size, heard in ((0.0, False), (0.02, True)):
        imu, _ = shaken(size, seed)
        assert turns_with_hum(imu, HUM, none(imu)) is heard


def test_what_is_left_is_the_motion():
    imu, still = shaken(0.05)
    gyro, accel = without_hum(imu, HUM, none(imu))
    inside = slice(250, -250)  # a filter of 2 Hz rings for half a second at the ends
    for got, wanted, before in ((gyro, still.gyro, imu.gyro), (accel, still.accel, imu.accel)):
        left, was = (np.sqrt(np.mean((x - wanted)[inside] ** 2)) for x in (got, before))
        assert left < 0.25 * was  # the hum's phase wanders beyond the band that is taken out, and noise in it goes too


@pytest.mark.parametrize(("size", "turns", "goes"), [(0.3, 0.05, True), (0.3, 0.0, False), (0.02, 0.05, False)])
def test_a_second_line_goes_as_well_where_it_is_louder_than_noise_and_turns_the_sensor(size, turns, goes):
    imu, still = shaken(0.05)
    second = np.sin(2 * np.pi * 97.0 * imu.time)[:, None] * np.array([0.5, 1.0, 0.3])
    imu = replace(imu, gyro=imu.gyro + turns * second, accel=imu.accel + size * second)
    gyro, accel = without_hum(imu, HUM, none(imu))
    once = replace(imu, gyro=gyro, accel=accel)
    out = without_further_hums(once, none(imu))
    if not goes:
        assert out is once
        return
    inside = slice(250, -250)
    left = np.sqrt(np.mean((out.accel - still.accel)[inside] ** 2))
    alone, _ = shaken(0.05)
    without = np.sqrt(np.mean((without_hum(alone, HUM, none(alone))[1] - still.accel)[inside] ** 2))
    assert left == pytest.approx(without, rel=0.1)  # as if it had never been there


def test_one_hum_alone_is_taken_out_once():
    imu, _ = shaken(0.05)
    gyro, accel = without_hum(imu, HUM, none(imu))
    once = replace(imu, gyro=gyro, accel=accel)
    assert without_further_hums(once, none(imu)) is once


def test_samples_that_do_not_count_stay_as_they_were():
    imu, _ = shaken(0.05)
    skip = none(imu)
    skip[1000:1010] = True
    gyro, accel = without_hum(imu, HUM, skip)
    assert np.array_equal(gyro[skip], imu.gyro[skip])
    assert np.array_equal(accel[skip], imu.accel[skip])


def hummed(size, wander, seed=0):
    """The same hand with a hum of the accelerometer alone, its phase a random walk of `wander` rad per root second."""
    rng = np.random.default_rng(seed)
    _, still = shaken(0.0, seed)
    phase = np.cumsum(wander / np.sqrt(RATE) * rng.standard_normal(still.time.size))
    waves = np.sin(2 * np.pi * HUM * still.time + phase)[:, None] * np.array([1.0, 0.5, 0.2])
    return replace(still, accel=still.accel + size * waves), still


@pytest.mark.parametrize("seed", range(3))
def test_a_hum_that_wanders_becomes_a_steady_line_as_strong(seed):
    imu, still = hummed(1.0, 0.05, seed)
    inside = slice(250, -250)
    left = {}
    for name, accel in (("before", imu.accel), ("after", with_steady_hum(imu, HUM, none(imu)))):
        hum = (accel - still.accel)[inside]
        line = steady(still.time[inside], hum, HUM)
        left[name] = np.sqrt(np.mean((hum - line) ** 2))
        size = np.sqrt(2 * np.mean(line**2, axis=0))
    assert left["before"] > 0.02
    assert left["after"] < 0.01 < left["before"] / 2  # half of the noise, which was 0.02; what is beyond 2 Hz stays
    np.testing.assert_allclose(size, [1.0, 0.5, 0.2], rtol=0.01)


def test_a_steady_hum_and_a_faint_one_stay_as_they_are():
    for size, wander in ((1.0, 0.0), (0.02, 0.05)):
        imu, _ = hummed(size, wander)
        assert np.array_equal(with_steady_hum(imu, HUM, none(imu)), imu.accel)


def test_sidebands_reach_further_the_louder_a_hum_is():
    reaches = []
    for size in (0.02, 0.2, 1.0):
        imu, still = hummed(size, 0.05)
        reaches.append(sidebands([imu.accel - steady(still.time, imu.accel - still.accel, HUM)], RATE, HUM))
    assert reaches == sorted(reaches)
    assert reaches[0] == 0.0
    assert reaches[-1] >= NOTCH.reach_hz[2]
