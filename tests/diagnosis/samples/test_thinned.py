"""Poses whose errors last count as often as they say something new. The motion here is a sum of sines, by itself."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imubench.diagnosis.samples.pose_correlation import correlated_poses as told
from imubench.recording import Imu, Pose, Recording

RATE, SECONDS, LEVEL = 200.0, 20.0, 1e-3
MISALIGNED, LATE, BIAS = np.array([0.02, -0.01, 0.015]), 0.004, np.array([0.01, -0.02, 0.005])


def turned(time):
    """Attitudes as Euler angles that are sums of sines, up to 3 Hz."""
    angles = [[0.5, 0.9, 0.1], [0.3, 2.1, 1.0], [0.4, 3.0, 2.0]]
    return Rotation.from_euler("zyx", np.stack([a * np.sin(2 * np.pi * f * time + p) for a, f, p in angles], axis=1))


def recorded(errors, **changes):
    """A gyroscope, turned in its mount, late and biased, beside a pose that is wrong by rotation vectors (n, 3) rad."""
    time = np.arange(0, SECONDS, 1 / RATE)
    h = 1e-4
    rate = (turned(time - h).inv() * turned(time + h)).as_rotvec() / (2 * h)
    gyro = Rotation.from_rotvec(MISALIGNED).inv().apply(rate) + BIAS
    gyro += 1e-3 * np.random.default_rng(3).standard_normal(gyro.shape)
    imu = Imu("imu1", time + LATE, gyro, np.zeros_like(gyro), RATE)
    q = (turned(time) * Rotation.from_rotvec(errors)).as_quat(canonical=True)[:, [3, 0, 1, 2]]
    return Recording("r", "free", (imu,), poses=(Pose("segment1", time, None, q, **changes),))


def white(seed=0):
    return LEVEL * np.random.default_rng(seed).standard_normal((round(SECONDS * RATE), 3))


def lasting(samples, seed=0):
    """Errors of the same size that are averages over some samples."""
    mean = np.apply_along_axis(np.convolve, 0, white(seed), np.ones(samples) / samples, "same")
    return LEVEL * mean / mean.std()


def every(recording):
    """How many samples apart those are that count; 1 without a mask."""
    masks = told(recording)[0]
    assert set(masks) in (set(), {"pose1.position", "pose1.rotation"})
    if not masks:
        return 1
    return int(np.diff(np.flatnonzero(masks["pose1.rotation"])).max())


@pytest.mark.parametrize("seed", range(5))
def test_independent_errors_all_count(seed):
    assert every(recorded(white(seed))) == 1


@pytest.mark.parametrize(("samples", "apart"), [(4, 4), (8, 8)])
def test_errors_that_last_count_once(samples, apart):
    assert every(recorded(lasting(samples))) == apart  # at most 60 ms apart: 12 samples


def test_errors_that_last_longer_than_that_wander():
    assert set(told(recorded(lasting(30)))[1]) == {"pose1"}  # 150 ms


def test_a_declared_noise_that_is_there_is_believed():
    assert every(recorded(white(), rotation_noise_std=LEVEL)) == 1
    assert every(recorded(lasting(8), rotation_noise_std=LEVEL)) == 8  # from one sample to the next it is far smaller


def test_a_gyroscope_louder_than_the_pose_is_no_lasting_error():
    recording = recorded(0.001 * white())
    loud = np.random.default_rng(1).standard_normal(recording.imus[0].gyro.shape)
    imu = Imu("imu1", recording.imus[0].time, recording.imus[0].gyro + 0.1 * loud, loud, RATE, gyro_noise_std=0.1)
    assert every(Recording("r", "free", (imu,), poses=recording.poses)) == 1


def test_moments_in_which_a_pose_was_not_seen_do_not_matter():
    recording = recorded(lasting(8))
    q = recording.poses[0].quaternion.copy()
    q[500:600] = np.nan
    pose = Pose("segment1", recording.poses[0].time, None, q)
    assert every(Recording("r", "free", recording.imus, poses=(pose,))) == 8


def test_a_pose_without_an_attitude_or_a_gyroscope_is_left_as_it_is():
    recording = recorded(lasting(8))
    (pose,) = recording.poses
    placed = Pose("segment1", pose.time, np.zeros((len(pose.time), 3)))
    assert told(Recording("r", "free", recording.imus, poses=(placed,))) == ({}, {})
    assert told(Recording("r", "free", poses=(pose,))) == ({}, {})
