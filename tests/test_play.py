"""Prescribed motion against independent computations."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import median_filter

from imubench import rotations
from imubench.models import RIG_FILES as RIGS
from imubench.sim import rigs
from imubench.sim.compile import DRIVEN_ARMATURE, compile_model, specify
from imubench.sim.driven import evaluate, joint_state
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.readout import read_truth
from imubench.sim.signals import STILL, Sines, hand

# Forces of the rig (tens of N) against an armature of 1e13 leave 1e-12; rounding adds 1e-14 of 100 m/s^2.
EXACT = 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_hinge_imus_read_what_matrix_calculus_says(seed, random_motion, jets):
    rig = rigs.random_hinge(np.random.default_rng(seed))
    motion = random_motion(seed)
    truth = play(rig, motion, 2.0, 500.0)
    other = jets(motion, truth.time)
    for i, (mount, sensor) in enumerate(zip(rig.mounts, truth.sensors, strict=True)):
        where, rate, force = other.imu(i + 1, mount.position, rotations.to_matrix(mount.quaternion))
        assert_allclose(sensor.position, where, atol=EXACT)
        assert_allclose(sensor.gyro, rate, atol=EXACT)
        assert_allclose(sensor.specific_force, force, atol=EXACT)
        joint = sensor.position + rotations.rotate(sensor.quaternion, sensor.joint_vector)
        assert_allclose(joint, other.p[0], atol=EXACT)
        assert_allclose(rotations.rotate(sensor.quaternion, sensor.joint_axis), other.R1[0][:, :, 1], atol=EXACT)
    assert_allclose(truth.joint_angle, motion.angle(truth.time)[0], atol=EXACT)


@pytest.mark.parametrize("family", list(RIGS))
def test_driven_forward_dynamics_is_inverse_dynamics(family, random_motion):
    rig = rigs.standard_rig(family)
    trajectory = random_motion(3)(np.linspace(0, 3, 200))
    driven = compile_model(rig, driven="all")
    state = joint_state(rig, driven, trajectory)
    plain = specify(rig, watch_segments=False).compile()
    data = mujoco.MjData(plain)
    expected = []
    for qpos, qvel, qacc in zip(*state, strict=True):
        data.qpos, data.qvel, data.qacc = qpos, qvel, qacc
        mujoco.mj_inverse(plain, data)
        expected.append(data.sensordata.copy())
    assert_allclose(evaluate(driven, *state), expected, atol=EXACT)


@pytest.mark.parametrize("changes", [{}, {"base": "fixed"}, {"locked_at": 0.3}], ids=str)
def test_segments_move_as_mujoco_has_them(changes, random_motion):
    """The segments' own kinematics against MuJoCo's sensors on them, joints driven alike."""
    rig = rigs.random_hinge(np.random.default_rng(0), **changes)
    trajectory = random_motion(3)(np.linspace(0, 3, 200))
    watched = specify(rig).compile()
    watched.dof_armature[:] = DRIVEN_ARMATURE
    mujoco.mj_setConst(watched, mujoco.MjData(watched))
    data = evaluate(watched, *joint_state(rig, watched, trajectory))
    by_sensors = read_truth(rig, watched, trajectory.time, data)
    by_joints = read_truth(rig, watched, trajectory.time, data, played=trajectory)
    for a, b in zip(by_sensors.segments, by_joints.segments, strict=True):
        for key in ("position", "velocity", "rate", "acceleration", "angular_acceleration"):
            assert_allclose(getattr(a, key), getattr(b, key), atol=EXACT, err_msg=key)
        assert_allclose(np.abs(np.sum(a.quaternion * b.quaternion, axis=1)), 1.0, atol=EXACT)
    assert_allclose(by_sensors.joint_angle, by_joints.joint_angle, atol=EXACT)
    assert_allclose(by_sensors.joint_rate, by_joints.joint_rate, atol=EXACT)


@pytest.mark.parametrize("family", list(RIGS))
def test_rates_and_accelerations_are_derivatives_of_the_pose(family, random_motion):
    h = 1e-3
    truth = play(rigs.standard_rig(family), random_motion(7), 4.0, 1 / h)
    for body in (*truth.segments, *truth.sensors):
        # Central differences of a 1.5 Hz motion at 1 kHz: error h^2/12 of the fourth derivative.
        second = np.diff(body.position, 2, axis=0) / h**2
        assert_allclose(second, body.acceleration[1:-1], atol=2e-3)
    for sensor in truth.sensors:
        turned = rotations.multiply(rotations.conjugate(sensor.quaternion[:-2]), sensor.quaternion[2:])
        assert_allclose(rotations.log(turned) / (2 * h), sensor.gyro[1:-1], atol=1e-3)
        assert_allclose(np.gradient(sensor.gyro, h, axis=0)[1:-1], sensor.angular_acceleration[1:-1], atol=1e-2)


@pytest.mark.parametrize("family", list(RIGS))
def test_at_rest_an_accelerometer_points_up(family):
    truth = play(rigs.standard_rig(family), AngleMotion(), 0.1, 100.0)
    for sensor in truth.sensors:
        up_s = rotations.rotate_back(sensor.quaternion, np.array([0.0, 0.0, 9.81]))
        assert_allclose(sensor.specific_force, up_s, atol=EXACT)
        assert_allclose(sensor.gyro, 0.0, atol=EXACT)


def test_pendulum_joint_vector_is_the_papers():
    truth = play(rigs.pendulum(), AngleMotion(), 0.1, 100.0)
    assert_allclose(truth.sensors[0].joint_vector[0], [-0.06, 0.02, 0.2], atol=EXACT)
    assert_allclose(truth.segments[0].position, 0.0, atol=EXACT)


def test_a_locked_hinge_has_no_relative_rate_at_all(random_motion):
    motion = replace(random_motion(1), angle=STILL)
    rig = rigs.random_hinge(np.random.default_rng(1), locked_at=0.4)
    truth = play(rig, motion, 2.0)
    assert np.all(truth.joint_rate == 0.0) or np.abs(truth.joint_rate).max() < 1e-14
    assert_allclose(truth.joint_angle, 0.4, atol=EXACT)


def test_base_can_be_fixed_in_any_orientation():
    q = rotations.random(np.random.default_rng(2))
    truth = play(rigs.hinge(base="fixed", base_quaternion=q), AngleMotion(angle=Sines(1.0, 0.7)), 1.0)
    assert_allclose(np.abs(truth.segments[0].quaternion @ q), 1.0, atol=EXACT)
    assert_allclose(truth.sensors[0].gyro, 0.0, atol=EXACT)
    assert_allclose(truth.sensors[1].gyro[:, 1], Sines(1.0, 0.7)(truth.time)[1], atol=EXACT)


def test_result_does_not_depend_on_the_number_of_threads(random_motion):
    rig = rigs.random_hinge(np.random.default_rng(0))
    one, two = (play(rig, random_motion(0), 3.0, threads=n) for n in (1, 2))
    assert np.array_equal(one.sensors[1].specific_force, two.sensors[1].specific_force)


def test_hand_signal_is_band_limited_and_as_large_as_asked():
    rng = np.random.default_rng(0)
    value, first, second = hand(rng, 2000.0, std=2.0, bandwidth=1.5)(np.arange(0, 2000, 0.01))
    assert value.std() == pytest.approx(2.0, rel=0.05)  # some 7000 independent coefficients: 1 %, the mean included
    power = np.abs(np.fft.rfft(value * np.hanning(value.size))) ** 2
    frequency = np.fft.rfftfreq(value.size, 0.01)
    assert power[frequency > 3.0].sum() < 1e-6 * power.sum()  # over 70 dB at twice the bandwidth
    assert_allclose(np.gradient(value, 0.01)[2:-2], first[2:-2], atol=0.04)  # h^2/6 of a third derivative up to 2000
    assert_allclose(np.gradient(first, 0.01)[2:-2], second[2:-2], atol=0.4)  # and up to 20,000 of the fifth


@pytest.mark.parametrize("band", [1.0, 3.0])
def test_what_is_square_in_a_hand_does_not_hum(band):
    """A spline through one random number a knot is livelier at its knots: its squares had a line of 4 to 16 %."""
    time = np.arange(0, 1000, 0.02 / band)
    _, first, second = hand(np.random.default_rng(1), 1000.0, std=1.0, bandwidth=band)(time)
    frequency = np.fft.rfftfreq(time.size, 0.02 / band)
    for signal in (first**2, second**2):
        line = 4 * np.abs(np.fft.rfft(signal * np.hanning(time.size))) / time.size / signal.std()  # amplitudes
        over = line / median_filter(line, 201)
        assert np.all((line < 2e-3) | (over < 8.0) | (frequency < 2 * band))  # by chance 4.5 of 30,000
