"""Noise of averaged samples: what is beside it is as powerful as in the recording's own."""

import numpy as np
import pytest

from imubench.diagnosis.problem.averaging import AS_RECORDED, Averaging

RNG_SAMPLES, TIMES = 200_000, 4


def test_power_is_that_of_the_recordings_samples():
    """Of white noise and a slow wave, averaged by fours: both ways of counting agree."""
    rng = np.random.default_rng(1)
    wave = np.sin(2 * np.pi * np.arange(RNG_SAMPLES) / 1000)
    noise = 0.5 * rng.normal(size=RNG_SAMPLES)
    fewer = (wave + noise).reshape(-1, TIMES).mean(axis=1)
    averaging = Averaging({"imu1.gyro": TIMES**-0.5})
    in_fit = np.mean(fewer**2) / (averaging.share("imu1.gyro") * 0.5) ** 2
    recorded = np.mean((wave + noise) ** 2) / 0.5**2
    assert averaging.power("imu1.gyro", in_fit) == pytest.approx(recorded, rel=0.01)  # 0.3 % of chance
    assert averaging.power_in_fit("imu1.gyro", averaging.power("imu1.gyro", 7.0)) == pytest.approx(7.0)


def test_levels_and_steps_are_those_of_the_recordings_samples():
    averaging = Averaging({"imu1.gyro": 0.5})
    assert averaging.in_fit({"imu1.gyro": 0.2, "imu1.accel": 0.3}) == {"imu1.gyro": 0.1, "imu1.accel": 0.3}
    assert averaging.step("imu1.gyro", 0.04) == pytest.approx(0.01)


def test_samples_as_recorded_change_nothing():
    assert AS_RECORDED.share("imu2.accel") == 1.0
    assert AS_RECORDED.power("imu2.accel", 3.7) == pytest.approx(3.7)
    assert AS_RECORDED.step("imu2.accel", 0.02) == pytest.approx(0.02)
