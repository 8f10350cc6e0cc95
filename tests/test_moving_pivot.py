"""A joint centre that accelerates: its scenarios, and the filter that cancels it with two IMUs."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench import rotations
from imubench.errors import InputError
from imubench.estimators import two_imu_centre
from imubench.estimators.arve_d import ArveD
from imubench.estimators.centre_ekf import covariances_of
from imubench.estimators.mrvs import solve_differenced
from imubench.estimators.two_imu_centre import TwoImuCentre, estimate
from imubench.estimators.two_imu_model import Noise
from imubench.scenarios.moving_pivot import (
    HARMONICS,
    gait,
    hip_mounts,
    moving,
    pelvis,
    pendulum_truth,
    shared_centre,
    thigh,
)
from imubench.scenarios.pendulum import R_TEXT, ellipse
from imubench.sim.imu_model import observe
from imubench.sim.signals import STILL, Sines
from tests.hips import IMU, errors, hip

GRAVITY_W = np.array([0.0, 0.0, -9.81])


# --- scenarios ---


def test_the_centre_accelerates_as_stated():
    time = np.arange(20000) / 1000
    for joint, low, high in (("hip", 2.7, 3.4), ("knee", 5.5, 7.0)):  # 3.1 and 6.2, times the square of a rate of +-5 %
        for seed in range(5):
            signals = gait(np.random.default_rng(seed), joint)
            a = np.stack([signals[k](time)[2] for k in "xyz"])
            assert low < np.sqrt(np.mean(np.sum(a**2, axis=0))) < high
    up = gait(np.random.default_rng(0))["z"]
    assert 1.8 <= up.frequency[0] <= 2.0  # the step rate
    assert up.amplitude[0] == HARMONICS["hip"][2][0][1]


def test_scale_scales_and_zero_rests():
    time = np.linspace(0, 5, 500)
    one, half, none = (gait(np.random.default_rng(3), "hip", s) for s in (1.0, 0.5, 0.0))
    for k in "xyz":
        assert_allclose(half[k](time)[2], one[k](time)[2] / 2, atol=1e-12)  # rounding
        assert (none[k](time)[2] == 0).all()


def test_a_moving_pivot_is_felt_in_full(jets):
    motion = moving(ellipse(), gait(np.random.default_rng(0)))
    rig, truth = pendulum_truth(motion, 3.0, 200.0)
    sensor, by_hand = truth.sensors[0], jets(motion, truth.time)
    where, rate, force = by_hand.imu(1, -R_TEXT, np.eye(3))
    assert truth.rig == rig.family == "pendulum"
    assert_allclose(sensor.specific_force, force, atol=1e-9)  # as in test_play.py
    assert_allclose(sensor.gyro, rate, atol=1e-9)
    assert_allclose(sensor.position, where, atol=1e-9)
    assert_allclose(sensor.joint_vector, np.broadcast_to(R_TEXT, sensor.joint_vector.shape), atol=1e-9)


def test_two_segments_share_one_centre():
    _, truth = hip(0, duration=2.0)
    joint = [s.position + rotations.rotate(s.quaternion, s.joint_vector) for s in truth.sensors]
    assert_allclose(joint[0], joint[1], atol=1e-12)  # rounding
    assert np.ptp(joint[0], axis=0).min() > 0.01
    assert [s.name for s in truth.sensors] == ["imu1", "imu2"]
    forces = []  # carried to the joint centre, both specific forces are one
    for s in truth.sensors:
        K = np.cross(s.angular_acceleration, s.joint_vector) + np.cross(s.gyro, np.cross(s.gyro, s.joint_vector))
        forces.append(rotations.rotate(s.quaternion, s.specific_force + K))
    assert_allclose(forces[0], forces[1], atol=1e-9)
    assert_allclose(forces[0] + GRAVITY_W, truth.segments[0].acceleration, atol=1e-9)


# --- the pivot cancels ---


@pytest.mark.parametrize("scale", [0.0, 0.1, 1.0])
def test_two_imus_find_a_hip_whatever_it_does(scale):
    for seed in range(2):
        recording, truth = hip(seed, scale)
        answer = estimate(recording)
        one, two = errors(answer, truth)
        assert one < 0.002  # 0.8 mm measured; the pelvis turns by 4 deg only
        assert two < 0.001  # 0.4 mm measured
        assert 0.7 < answer.details["innovation_squared"] < 1.4  # a swing is no random walk: 1.0 to 1.2 measured


def test_one_imu_takes_the_pivots_acceleration_for_a_lever():
    rest, walking = (hip(0, scale) for scale in (0.0, 1.0))
    found = []
    for _, truth in (rest, walking):
        imu = observe(truth, IMU, np.random.default_rng(0)).imu("imu2")
        up = rotations.to_matrix(truth.sensors[1].quaternion[::10])[:, 2, :]
        acceleration = imu.accel - 9.81 * up  # the true orientation: the best that one IMU can have
        r, _ = solve_differenced(imu.gyro, acceleration, imu.time)
        centre = ArveD(covariances_of("arve-d", "constant"))
        last = [centre.update(w, a, 0.01) for w, a in zip(imu.gyro, acceleration, strict=True)][-1]
        found.append([np.linalg.norm(x - R_TEXT) for x in (r, last)])
    assert max(found[0]) < 0.002  # at rest both are right: 0.2 and 0.5 mm
    assert min(found[1]) > 0.02  # a tenth of |r|, the paper's upper limit; docs/moving-pivot.md has the figures


def test_gravity_cancels_too():
    recording, truth = hip(1)
    found = []
    for extra in (-9.81, 0.0, 15.0):  # m/s^2 more than there is, felt along the true vertical
        imus = tuple(
            replace(imu, accel=imu.accel + extra * rotations.to_matrix(s.quaternion[::10])[:, 2, :])
            for imu, s in zip(recording.imus, truth.sensors, strict=True)
        )
        found.append(errors(estimate(replace(recording, imus=imus)), truth))
    assert np.max(found) < 0.002  # as with gravity
    assert np.ptp(found, axis=0).max() < 0.0005  # half a millimetre: noise is carried on by another R


def test_walking_in_hip_and_thigh():
    recording, truth = hip(2, motions=(pelvis(), thigh()))
    one, two = errors(estimate(recording), truth)
    assert one < 0.004
    assert two < 0.002


# --- r may vary ---


def test_a_slow_slide_is_followed():
    rng = np.random.default_rng(5)
    one, two = hip_mounts(rng)
    slide = Sines(0.02, 0.05)  # 20 mm in 5 s: an acceleration of 0.002 m/s^2, below the noise
    sliding = replace(two, path=(slide, STILL, slide))
    truth = shared_centre((pelvis(scale=3.0), ellipse()), (one, sliding), gait(rng), 10.0)
    recording = observe(truth, IMU, rng)
    true = truth.sensors[1].joint_vector[::10]
    told, not_told = (
        estimate(recording, replace(two_imu_centre.noise_of(recording), r_density=density))
        for density in (0.006, 0.0003)
    )
    late = told.time > 2
    at = np.searchsorted(np.arange(1000) / 100, told.time - 1e-6)
    ours, theirs = (np.linalg.norm(a.value[:, 1] - true[at], axis=-1)[late].mean() for a in (told, not_told))
    assert ours < 0.004  # 2.6 mm measured, of 28 mm
    assert theirs > 2 * ours  # 9.5 mm


# --- streams, recordings, bad input ---


def test_a_stream_is_the_recording():
    recording, _ = hip(0, duration=3.0)
    answer = estimate(recording)
    f = TwoImuCentre(two_imu_centre.noise_of(recording))
    assert np.isnan(f.answer()[1]).all()
    one, two = recording.imus
    steps = np.diff(one.time, prepend=one.time[0]).tolist()
    rows = [
        f.update(np.stack([one.gyro[k], two.gyro[k]]), np.stack([one.accel[k], two.accel[k]]), dt)
        for k, dt in enumerate(steps)
    ]
    assert np.isnan(rows[98]).all()
    assert_allclose(np.array(rows[99:]), answer.value, atol=1e-12)  # the same operations
    assert_allclose(answer.time, one.time[99:])
    assert answer.covariance.shape == (201, 6, 6)
    assert (np.linalg.eigvalsh(answer.covariance) > 0).all()


def test_turned_sensors_turn_their_vectors():
    recording, _ = hip(3, duration=4.0)
    q = rotations.random(np.random.default_rng(6))
    one, two = recording.imus
    turned = replace(two, gyro=rotations.rotate(q, two.gyro), accel=rotations.rotate(q, two.accel))
    before, after = estimate(recording), estimate(replace(recording, imus=(one, turned)))
    assert_allclose(
        after.value[-1, 1], rotations.rotate(q, before.value[-1, 1]), atol=1e-4
    )  # starts stop at 1e-8 of their cost
    assert_allclose(after.value[-1, 0], before.value[-1, 0], atol=1e-4)


def test_bad_input():
    recording, _ = hip(0, duration=1.5)
    with pytest.raises(InputError, match="expected two IMUs, got imu1"):
        estimate(replace(recording, imus=recording.imus[:1]))
    with pytest.raises(InputError, match="two-imu-centre expected more than 150 samples of both IMUs, got 150"):
        estimate(recording, initial_samples=150)
    with pytest.raises(InputError, match="initial_samples: expected 10 or more, got 9"):
        TwoImuCentre(initial_samples=9)
    with pytest.raises(InputError, match=r"noise.gyro_std: expected a number > 0, got 0"):
        Noise(gyro_std=(0.0, 0.1))
    with pytest.raises(InputError, match="unknown joint 'elbow'; known: hip, knee"):
        gait(np.random.default_rng(0), "elbow")
    f = TwoImuCentre(two_imu_centre.noise_of(recording))
    one, two = recording.imus
    samples = [(np.stack([one.gyro[k], two.gyro[k]]), np.stack([one.accel[k], two.accel[k]])) for k in range(120)]
    for w, a in samples:
        f.update(w, a, 0.01)
    x, P = f.x.copy(), f.P.copy()
    bad = samples[0][0].copy()
    bad[1, 2] = np.nan
    with pytest.raises(InputError, match="two-imu-centre: expected finite samples, got gyro"):
        f.update(bad, samples[0][1], 0.01)
    with pytest.raises(InputError, match=r"expected a time step > 0 s, got 0.0"):
        f.update(*samples[0], 0.0)
    assert (f.x == x).all()
    assert (f.P == P).all()
