"""The reference of IMUs on foam, itself judged: two sensors on one body, one of which rocks, by a known turn."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.real_axes import carried_axes, rotation_between
from imubench.errors import InputError
from imubench.recording import Imu, Recording
from imubench.rotations import from_axis_angle, multiply, rotate, rotate_back
from tests.chain import readings

RATE = 40.0  # Hz
TURN = multiply(from_axis_angle([1.0, 0, 0], 0.2), from_axis_angle([0, 0.6, 0.8], -0.15))  # foam mounts: 5 to 13 deg


def imu_of(gyro, accel, name="imu1"):
    return Imu(name, np.arange(len(gyro)) / RATE, gyro, accel, RATE)


def beside(segment, rocking=0.0, late=0.0, bias=0.0, seed=0):
    """An IMU screwed on a segment of a made-up chain, and one on foam beside it, turned by TURN."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(60 * RATE)) / RATE
    gyro, accel = readings(time, segment)
    after, felt = readings(time, segment, delay=late)
    sway = rocking * np.sin(2 * np.pi * 12.3 * time[:, None] + rng.uniform(0, 6, size=3))
    foam = rotate(TURN, after + sway) + bias + 0.01 * rng.normal(size=after.shape)
    return imu_of(gyro + 0.01 * rng.normal(size=gyro.shape), accel), imu_of(foam, rotate(TURN, felt))


def angle_off(found, expected):
    return np.degrees(np.arccos(np.clip(np.sum(found * expected, axis=-1), -1, 1)))


@pytest.mark.parametrize(
    ("what", "most"),
    [
        ({}, 0.02),  # deg: noise of 0.01 rad/s against 2 rad/s, 2400 samples
        ({"rocking": 0.7}, 0.05),  # what foam at 12 Hz adds is far above the band
        ({"late": 0.002}, 0.3),  # 2 ms of some rad/s^2: hundredths of a rad/s, mostly across the rates
        ({"bias": 0.01}, 0.3),  # 0.6 deg/s
    ],
)
def test_the_rotation_between_two_imus_of_one_body(what, most):
    one, other = beside(2, **what)
    for axis in np.eye(3):
        assert angle_off(rotation_between(one, other).apply(axis), rotate(TURN, axis)) < most


def test_axes_are_carried_for_each_imu_by_its_own_rotation():
    pairs = [beside(2), beside(3, seed=1)]
    rigid, foam = (
        Recording("r", "hinge", tuple(replace(p[k], name=f"imu{i + 1}") for i, p in enumerate(pairs))) for k in (0, 1)
    )
    axes = np.array([[0.0, 1.0, 0.0], [0.0, 0.6, 0.8]])
    found = carried_axes(axes, rigid, foam)
    assert angle_off(found, rotate(TURN, axes)).max() < 0.03
    assert angle_off(found, rotate_back(TURN, axes)).max() > 10.0  # and not the other way round


def test_one_direction_of_turning_tells_no_rotation():
    time = np.arange(2400) / RATE
    gyro = np.outer(np.sin(time), [0.0, 1.0, 0.0])
    accel = np.tile([0, 0, 9.81], (2400, 1))
    with pytest.raises(InputError, match="imu1: expected a segment that turns about two directions, got one"):
        rotation_between(imu_of(gyro, accel), imu_of(rotate(TURN, gyro), accel))
