"""What every estimator promises, the gyroscope-only method, and two IMUs on one clock."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.hinge_rigs import random_rig
from benchmarks.pendulum_runs import circling
from imubench import rotations
from imubench.errors import InputError
from imubench.estimators import ESTIMATORS, find
from imubench.estimators.seel2012 import estimate as seel
from imubench.paired import paired
from imubench.recording import Imu, Recording

NOISE = 0.002, 0.02  # rad/s, m/s^2
HINGE = [e for e in ESTIMATORS.values() if e.quantity == "joint_axis"]
CENTRE = [e.name for e in ESTIMATORS.values() if e.quantity == "joint_vector" and e.imus == 1]
every_estimator = pytest.mark.parametrize("name", [e.name for e in HINGE])
every_judge = pytest.mark.parametrize("name", [e.name for e in HINGE if e.uncertainty])
every_centre = pytest.mark.parametrize("name", CENTRE)


COUNT = 600  # samples in which nothing moves as it should: more of them tell no more


def rig_of(seed, **options):
    return random_rig(np.random.default_rng(seed), **options)


def recording_of(gyro, accel, rate=100.0):
    time = np.arange(gyro.shape[1]) / rate
    return Recording("r", "hinge", tuple(Imu(f"imu{i + 1}", time, gyro[i], accel[i], rate) for i in range(2)))


def test_the_dict_is_keyed_by_name_and_find_lists_it():
    assert all(name == e.name for name, e in ESTIMATORS.items())
    with pytest.raises(InputError, match=r"unknown estimator 'olsen'; known: olsson2020, seel2012"):
        find("olsen")


@every_judge
@pytest.mark.parametrize("planar", [False, True])
def test_the_answer_is_well_formed(name, planar):
    estimator = find(name)
    rig = rig_of(0, lever=0.03, planar=planar).noisy(np.random.default_rng(1), *NOISE)  # accelerometers alone suffice
    answer = estimator.estimate(rig.recording())
    assert (answer.estimator, answer.quantity) == (name, estimator.quantity)
    assert answer.status == "converged"
    assert answer.value.shape == (estimator.imus, 3)
    np.testing.assert_allclose(np.linalg.norm(answer.value, axis=1), 1.0, atol=1e-12)  # rounding
    assert answer.covariance is not None
    np.testing.assert_allclose(answer.covariance, answer.covariance.T, rtol=0, atol=1e-20)  # rounding of 1e-8
    values = np.linalg.eigvalsh(answer.covariance)
    assert values[0] >= -1e-12 * values[-1]  # rounding: two directions, along the axes, have none
    along = np.einsum("ij,ijk->ik", answer.value, answer.covariance.reshape(2, 3, 6))
    np.testing.assert_allclose(along, 0.0, atol=1e-12 * values[-1])  # unit vectors do not vary along themselves
    assert all(np.isfinite(v) for v in answer.details.values())


@every_estimator
def test_the_recording_is_left_as_it_was(name):
    rig = rig_of(1, count=500)
    recording = rig.recording()
    copies = [a.copy() for imu in recording.imus for a in (imu.time, imu.gyro, imu.accel)]
    find(name).estimate(recording)
    after = [a for imu in recording.imus for a in (imu.time, imu.gyro, imu.accel)]
    assert all((a == b).all() for a, b in zip(copies, after, strict=True))


@every_estimator
def test_one_imu_is_not_enough(name):
    recording = rig_of(1).recording()
    alone = Recording("lonely", "hinge", recording.imus[:1])
    with pytest.raises(InputError, match="lonely: expected two IMUs, got imu1"):
        find(name).estimate(alone)


@every_judge
@pytest.mark.parametrize("noise", [(0.0, 0.0), NOISE])
@pytest.mark.parametrize("motion", ["still", "locked", "locked, about one axis"])
def test_motion_without_information_is_called_so(name, noise, motion):
    rng = np.random.default_rng(2)
    planar = motion == "locked, about one axis"
    rig = rig_of(3, lever=0.0, count=COUNT, planar=planar)
    relative = rotations.random(rng)
    gyro = np.stack([rig.gyro[0], rotations.rotate(relative, rig.gyro[0])])
    accel = np.stack([rig.accel[0], rotations.rotate(relative, rig.accel[0])])
    if motion == "still":
        gyro, accel = 0 * gyro, np.repeat(accel[:, :1], COUNT, axis=1)
    gyro, accel = gyro + noise[0] * rng.normal(size=gyro.shape), accel + noise[1] * rng.normal(size=accel.shape)
    answer = find(name).estimate(recording_of(gyro, accel))
    assert answer.status == "not identifiable"
    assert answer.covariance is None
    assert "direction" in answer.no_covariance_because


def test_poses_without_any_rotation_are_enough_for_accelerometers():
    rng = np.random.default_rng(4)
    rig = rig_of(4, lever=0.0, count=4000)
    poses = np.repeat(rig.accel[:, ::100], 50, axis=1)  # 40 poses, 50 samples each, at rest in each
    gyro = NOISE[0] * rng.normal(size=poses.shape)
    answer = find("olsson2020").estimate(recording_of(gyro, poses + NOISE[1] * rng.normal(size=poses.shape)))
    assert answer.status == "converged"
    sign = np.sign(np.sum(answer.value[0] * rig.axes[0]))
    errors = np.linalg.norm(sign * answer.value - rig.axes, axis=1)
    assert errors.max() < 5 * np.sqrt(np.trace(answer.covariance))  # five sigma
    assert errors.max() < np.deg2rad(0.5)


# --- joint centres from one IMU ---


@every_centre
def test_a_joint_centre_is_well_formed(name):
    runs = circling(np.random.default_rng(0), duration=3.0)
    recording = runs.recording()
    answer = find(name).estimate(recording)
    assert (answer.estimator, answer.quantity, answer.status) == (name, "joint_vector", "converged")
    n = () if answer.time is None else (answer.time.size,)
    assert answer.value.shape == (*n, 1, 3)
    assert answer.time is None or np.isin(answer.time, runs.time).all()
    if find(name).uncertainty:
        covariance = answer.covariance.reshape(-1, 3, 3)
        assert covariance.shape[0] == (n[0] if n else 1)
        np.testing.assert_allclose(covariance, covariance.transpose(0, 2, 1), rtol=1e-9, atol=1e-15)  # rounding
        assert (np.linalg.eigvalsh(covariance) > 0).all()
    else:
        assert answer.covariance is None
        assert answer.no_covariance_because
    assert all(np.isfinite(v) for v in answer.details.values())
    assert np.array_equal(recording.imus[0].gyro, runs.gyro[0])  # left as it was
    assert np.array_equal(recording.imus[0].accel, runs.accel[0])


@every_centre
def test_a_joint_centre_takes_one_imu(name):
    with pytest.raises(InputError, match=f"{name} expected one IMU on a limb whose joint rests, got imu1, imu2"):
        find(name).estimate(rig_of(1).recording())


def test_importing_the_estimators_does_not_even_load_the_truth():
    script = (
        "import sys, imubench.estimators;"
        "print([m for m in sys.modules if m.startswith(('imubench.truth', 'imubench.sim', 'imubench.reference'))])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


# --- Seel 2012 ---


@pytest.mark.parametrize("planar", [False, True])
def test_gyroscopes_alone_give_the_axes_of_clean_data(planar):
    for seed in range(5):
        rig = rig_of(seed, lever=0.3, planar=planar)  # lever arms do not matter to gyroscopes
        errors = np.linalg.norm(seel(rig.recording()).value - rig.axes, axis=1)
        assert errors.max() < 1e-9  # steps stop at 1e-11 rad; the mounts are declared right, so are the signs


def test_the_sign_pairing_is_that_of_the_declared_mounts():
    rig = rig_of(0)
    half_turn = np.array([0.0, 1.0, 0.0, 0.0])  # about x: a mount declared upside down
    one, two = rig.recording().imus
    wrong = Imu(
        "imu2", two.time, two.gyro, two.accel, two.rate, mount_quaternion=rotations.multiply(half_turn, rig.mounts[1])
    )
    answer = seel(Recording("r", "hinge", (one, wrong)))
    np.testing.assert_allclose(answer.value, rig.axes * [[1.0], [-1.0]], atol=1e-9)  # as above
    assert answer.pairing == "unknown"  # nobody said how well the mounts are known
    sure = tuple(replace(imu, mount_rotation_std=0.02) for imu in (one, wrong))
    assert seel(Recording("r", "hinge", sure)).pairing == "from declared mounts"


@pytest.mark.long
def test_gyroscopes_alone_know_their_error():
    squares = []
    for seed in range(3):
        clean = rig_of(seed, count=400, rate=20.0)
        for run in range(60):
            answer = seel(clean.noisy(np.random.default_rng([seed, run]), *NOISE).recording())
            errors = (answer.value - clean.axes).ravel()
            squares.append(errors @ np.linalg.pinv(answer.covariance, rcond=1e-9, hermitian=True) @ errors / 4)
    assert 0.78 < np.mean(squares) < 1.22  # 180 runs of chi-square / 4 with 4 degrees of freedom: 1 +- 0.053


# --- two IMUs on one clock ---


def imu_of(name, time, rate):
    line = np.stack([time, 2 * time, -time], axis=1)  # linear, so that interpolation is exact
    return Imu(name, time, line, 10 * line, rate)


def test_equal_stamps_pass_through():
    rig = rig_of(0)
    both = paired(rig.recording())
    assert (both.gyro2 == rig.gyro[1]).all()
    assert (both.accel1 == rig.accel[0]).all()


@pytest.mark.parametrize(
    ("rates", "kept"), [((100.0, 100.0), "imu1"), ((100.0, 250.0), "imu1"), ((250.0, 100.0), "imu2")]
)
def test_the_faster_or_else_the_second_is_interpolated(rates, kept):
    imus = [
        imu_of("imu1", 0.003 + np.arange(300) / rates[0], rates[0]),
        imu_of("imu2", np.arange(300) / rates[1], rates[1]),
    ]
    both = paired(Recording("r", "hinge", tuple(imus)))
    assert np.isin(both.time, imus[kept == "imu2"].time).all()
    assert both.time[0] >= max(i.time[0] for i in imus)
    assert both.time[-1] <= min(i.time[-1] for i in imus)
    np.testing.assert_allclose(both.gyro1, both.gyro2, atol=1e-12)  # rounding; both read the same line
    np.testing.assert_allclose(both.accel1[:, 0], 10 * both.time, atol=1e-12)


def test_gaps_are_not_filled():
    fine, gappy = np.arange(400) / 100, np.arange(400) / 100 + 0.004
    one = imu_of("imu1", fine, 100.0)
    two = imu_of("imu2", np.delete(gappy, slice(100, 150)), 100.0)
    both = paired(Recording("r", "hinge", (one, two)))
    inside = (both.time > gappy[99]) & (both.time < gappy[150])
    assert not inside.any()
    assert both.time.size == 399 - 51  # stamp 0 precedes imu2; 51 stamps of imu1 fall into the gap


def test_a_single_lost_sample_is_bridged():
    one = imu_of("imu1", np.arange(400) / 100, 100.0)
    two = imu_of("imu2", np.delete(np.arange(400) / 100, 200), 100.0)
    assert paired(Recording("r", "hinge", (one, two))).time.size == 400


def test_no_common_samples():
    one = imu_of("imu1", np.array([0.0, 1.0, 2.0]), 100.0)
    two = imu_of("imu2", np.array([0.5, 1.5]), 100.0)
    with pytest.raises(InputError, match="r: expected imu1 and imu2 to have samples at common times, got none"):
        paired(Recording("r", "hinge", (one, two)))
