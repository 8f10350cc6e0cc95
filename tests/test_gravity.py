"""Gravity removal by a filter, by VQF and by a pose; each against the true acceleration."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks.pendulum_runs import GRAVITY, RATE, circling
from imubench import rotations
from imubench.errors import InputError
from imubench.estimators.gravity import GravityUkf, UkfSettings, linear_acceleration, remove_by_ukf, upright
from imubench.recording import Pose

CLEAN = 0.0, 0.0


def left_of_gravity(acceleration, runs, after=0.0):
    """Mean length in m/s^2 of what is left of gravity, or was taken too much, from `after` s on."""
    late = runs.time >= after
    return float(np.linalg.norm(acceleration - runs.acceleration, axis=-1)[..., late].mean())


def test_a_pose_takes_gravity_out_exactly():
    runs = circling(np.random.default_rng(0))
    assert_allclose(
        linear_acceleration(runs.recording(pose=True), "pose"), runs.acceleration[0], atol=1e-12
    )  # rounding


def test_a_pose_of_the_segment_goes_through_the_declared_mount():
    runs = circling(np.random.default_rng(0), noise=CLEAN)
    recording = runs.recording()
    mount = rotations.random(np.random.default_rng(1))
    imu = replace(recording.imus[0], mount_quaternion=mount)
    segment = rotations.multiply(runs.quaternion, rotations.conjugate(mount))
    posed = replace(recording, imus=(imu,), poses=(Pose("segment1", runs.time, quaternion=segment),))
    assert_allclose(linear_acceleration(posed, "pose"), runs.acceleration[0], atol=1e-9)  # rounding


def test_a_pose_at_another_rate_with_holes_and_flipped_signs_is_interpolated_on_the_sphere():
    runs = circling(np.random.default_rng(0), noise=CLEAN)
    q = runs.quaternion[::2].copy()
    q[::2] *= -1  # the same orientation
    q[50:53] = np.nan  # unseen for 60 ms
    time = np.append(runs.time[::2], 10.0)
    pose = Pose("segment1", time, quaternion=np.vstack([q, q[-1:]]))
    error = linear_acceleration(replace(runs.recording(), poses=(pose,)), "pose") - runs.acceleration[0]
    error = np.linalg.norm(error, axis=1)[:-2]
    # a turn interpolated over h: w' h^2 / 8 = 11.7 / 8 h^2 rad at most, times g; h is 20 ms, 80 ms across the hole
    assert np.delete(error, slice(98, 108)).max() < 1.2 * 11.7 / 8 * 0.02**2 * GRAVITY
    assert error.max() < 1.2 * 11.7 / 8 * 0.08**2 * GRAVITY


def test_a_sensor_at_rest_reads_zero():
    time, still = np.arange(100) / RATE, np.zeros((100, 3))
    assert_allclose(remove_by_ukf(still, np.tile([0, 0, GRAVITY], (100, 1)), time), 0.0, atol=1e-9)  # rounding
    for seed in range(10):
        f = rotations.rotate_back(rotations.random(np.random.default_rng(seed)), np.array([0, 0, GRAVITY]))
        left = np.linalg.norm(remove_by_ukf(still, np.tile(f, (100, 1)), time), axis=1)
        # sigma points 0.25 rad apart see the curve of the sphere, as long as the tilt is that unsure
        assert left.max() < 0.02
        assert left[-1] < 0.001


@pytest.mark.parametrize("f", [[0, 0, 1.0], [0, 0, -1.0], [1.0, 0, 0], [0.3, -0.5, -0.8], [1e-9, 0, -1.0]])
def test_upright_brings_a_force_up(f):
    f = np.array(f) * 9.81 / np.linalg.norm(f)
    assert_allclose(rotations.rotate(upright(f), f), [0, 0, 9.81], atol=1e-7)  # near the antipode half the digits go


def test_the_filter_turns_with_the_gyroscope_when_it_may_not_correct():
    runs = circling(np.random.default_rng(0), noise=CLEAN)
    closed = UkfSettings(gate=1e-9)
    acceleration = remove_by_ukf(runs.gyro, runs.accel, runs.time, settings=closed, first=runs.quaternion[0])
    # the mean of two rates errs by w'' dt^3 / 12 a step, w'' up to 74 rad/s^3 in sines that cancel: w' dt^2 / 12
    # in all, twice for both ends, times g; as much again for the axes that turn meanwhile
    assert np.abs(acceleration - runs.acceleration).max() < 2 * 2 * 11.7 * 0.01**2 / 12 * GRAVITY


def test_the_filter_finds_up_while_the_limb_moves():
    runs = circling(np.random.default_rng(0), count=5)
    acceleration = remove_by_ukf(runs.gyro, runs.accel, runs.time)
    assert left_of_gravity(acceleration, runs) < left_of_gravity(runs.accel - [0, 0, GRAVITY], runs) / 3
    assert left_of_gravity(acceleration, runs, 3.0) < 0.25  # 0.17 measured, 1 deg
    told = remove_by_ukf(
        runs.gyro, runs.accel, runs.time, settings=UkfSettings(tilt_std=0.01), first=runs.quaternion[0]
    )
    assert left_of_gravity(told, runs) < 0.2  # 0.13 measured


def test_runs_side_by_side_are_the_runs_one_by_one():
    runs = circling(np.random.default_rng(1), count=3, duration=2.0)
    together = remove_by_ukf(runs.gyro, runs.accel, runs.time)
    for i in range(3):
        assert_allclose(linear_acceleration(runs.recording(i)), together[i], atol=1e-12)  # rounding


def test_the_filter_knows_its_tilt_error_when_motion_is_noise():
    """Random turns, and accelerations that are white as the filter takes them to be: error over sigma near 1."""
    rng = np.random.default_rng(3)
    runs, n, settings = 300, 200, UkfSettings(motion_std=0.5, gate=100.0, tilt_std=0.2, gyro_noise_std=0.02)
    rate = np.repeat(rng.normal(scale=1.5, size=(runs, n // 20, 3)), 20, axis=1)
    q = rotations.random(rng, runs)
    ukf = GravityUkf(GRAVITY, settings, rotations.multiply(q, rotations.exp(-0.2 * rng.normal(size=(runs, 3)))))
    for k in range(n):
        if k:
            q = rotations.multiply(q, rotations.exp((rate[:, k - 1] + rate[:, k]) / (2 * RATE)))
        up = rotations.rotate_back(q, np.broadcast_to([0, 0, GRAVITY], (runs, 3)))
        ukf.update(rate[:, k] + 0.02 * rng.normal(size=(runs, 3)), up + 0.5 * rng.normal(size=(runs, 3)), 1 / RATE)
    error = rotations.log(rotations.multiply(rotations.conjugate(ukf.quaternion), q))
    level = np.linalg.svd(rotations.to_matrix(ukf.quaternion)[:, 2:, :])[2][:, 1:]  # two axes across up, sensor axes
    tilt, P = np.einsum("rki,ri->rk", level, error), level @ ukf.covariance @ level.transpose(0, 2, 1)
    square = np.einsum("ri,rij,rj->r", tilt, np.linalg.inv(P), tilt) / 2
    assert 0.77 < square.mean() < 1.23  # 300 runs of chi-square / 2: 1 +- 0.058, four of these


@pytest.mark.parametrize(("how", "bound"), [("vqf", 0.12), ("vqf-online", 0.2)])
def test_vqf(how, bound):
    pytest.importorskip("vqf", reason="vqf is an optional dependency")
    runs = circling(np.random.default_rng(0))
    assert left_of_gravity(linear_acceleration(runs.recording(), how)[None], runs, 3.0) < bound  # 0.08, 0.13 measured


def test_without_vqf_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "vqf", None)
    with pytest.raises(InputError, match=r"needs the package vqf: pip install 'imubench\[filters\]'"):
        linear_acceleration(circling(np.random.default_rng(0), duration=0.1).recording(), "vqf")


def test_bad_input():
    runs = circling(np.random.default_rng(0), duration=1.0)
    recording = runs.recording()
    with pytest.raises(InputError, match="unknown gravity removal 'magic'; known: ukf, vqf, vqf-online, pose"):
        linear_acceleration(recording, "magic")
    with pytest.raises(InputError, match="run: gravity removal by pose expected a pose of segment1 with quaternions"):
        linear_acceleration(recording, "pose")
    short = Pose("segment1", runs.time[:50], quaternion=runs.quaternion[:50])
    with pytest.raises(InputError, match=r"run: expected a pose of segment1 from 0 to 0.99 s, got 0 to 0.49 s"):
        linear_acceleration(replace(recording, poses=(short,)), "pose")


def test_vqf_refuses_gaps():
    pytest.importorskip("vqf", reason="vqf is an optional dependency")
    recording = circling(np.random.default_rng(0), duration=1.0).recording()
    imu, kept = recording.imus[0], np.r_[0:50, 60:100]
    gappy = replace(imu, time=imu.time[kept], gyro=imu.gyro[kept], accel=imu.accel[kept])
    with pytest.raises(
        InputError, match=r"imu1: vqf expected evenly spaced samples 0.01 s apart, got 0.11 s before row 50"
    ):
        linear_acceleration(replace(recording, imus=(gappy,)), "vqf")
