"""A joint centre that accelerates: scenarios, the filter that cancels it with two IMUs, what one IMU makes of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench import rotations
from imubench.errors import InputError
from imubench.estimators import find, two_imu_centre, two_imu_model, two_imu_start
from imubench.estimators.arve_d import ArveD
from imubench.estimators.centre_ekf import covariances_of
from imubench.estimators.mrvs import solve_differenced
from imubench.estimators.two_imu_centre import TwoImuCentre, estimate
from imubench.estimators.two_imu_model import A1, A2, R1, R2, STATES, TURN, W1, W2, Noise, constraint, predict, turn
from imubench.recording import Imu, Recording
from imubench.run import simulate
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
from imubench.sim.profiles import profile
from imubench.sim.signals import STILL, Sines

IMU = profile("xsens_mtw_awinda")
GRAVITY_W = np.array([0.0, 0.0, -9.81])


def hip(seed, scale=1.0, motions=None, duration=10.0):
    """A pelvis that turns as in walking, the paper's limb on it, the hip moving: recording and truth."""
    rng = np.random.default_rng(seed)
    truth = shared_centre(motions or (pelvis(), ellipse()), hip_mounts(rng), gait(rng, scale=scale), duration)
    return observe(truth, IMU, rng), truth


def vectors(truth):
    return np.stack([s.joint_vector.mean(axis=0) for s in truth.sensors])


def errors(answer, truth, after=2.0):
    """Mean |dr| in m of both IMUs, from `after` s on."""
    return np.linalg.norm(answer.value[answer.time > after] - vectors(truth), axis=-1).mean(axis=0)


def across(answer, truth):
    """The last error (6,) in m without its part along the hinge, which no hinge shows, and that part."""
    error = (answer.value[-1] - vectors(truth)).ravel()
    along = np.concatenate([s.joint_axis[0] for s in truth.sensors]) / np.sqrt(2)
    return error - along * (along @ error), along


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


# --- derivatives ---


def random_state(rng):
    x = rng.normal(size=STATES) * np.repeat([0.2, 0.2, 0.0, 3.0, 3.0, 20.0, 20.0], 3)
    return x, rotations.to_matrix(rotations.random(rng)), rng.normal(size=(2, 3)) * 10


def displaced(x, R, step):
    """The state after a step (21,), its turn taken into R."""
    y = x + step
    y[TURN] = 0.0
    return y, turn(step[TURN])[0] @ R


def apart(x, R, y, S):
    """The step (21,) from the state (y, S) to (x, R)."""
    step = x - y
    step[TURN] = rotations.log(rotations.from_matrix(R @ S.T))
    return step


def test_jacobian_of_the_constraint_by_finite_differences():
    rng = np.random.default_rng(0)
    h = 1e-6
    for _ in range(10):
        x, R, f = random_state(rng)
        _, H = constraint(x, R, *f)
        numeric = [
            (constraint(*displaced(x, R, e), *f)[0] - constraint(*displaced(x, R, -e), *f)[0]) / (2 * h)
            for e in h * np.eye(STATES)
        ]
        assert_allclose(H, np.stack(numeric, axis=1), atol=1e-7)  # h^2 of cubics of 20, and rounding 1e-14 over h


def test_jacobian_of_the_prediction_by_finite_differences():
    rng = np.random.default_rng(1)
    h, dt = 1e-6, 0.02
    for _ in range(10):
        x, R, _ = random_state(rng)
        y, S, F = predict(x, R, dt)
        numeric = []
        for e in h * np.eye(STATES):
            plus, minus = (predict(*displaced(x, R, step), dt)[:2] for step in (e, -e))
            numeric.append((apart(*plus, y, S) - apart(*minus, y, S)) / (2 * h))
        assert_allclose(F, np.stack(numeric, axis=1), atol=2e-8)  # rounding 1e-15 of log over h, and h^2


def test_jacobian_of_the_start_by_finite_differences():
    rng = np.random.default_rng(2)
    forces, levers, first = rng.normal(size=(2, 5, 3)) * 10, rng.normal(size=(2, 5, 3, 3)), rotations.random(rng)
    h = 1e-6
    for x in (rng.normal(size=9), np.zeros(9)):
        options = forces, levers, first, 0.3, 0.5
        residual = two_imu_start._residual
        numeric = [(residual(x + e, *options) - residual(x - e, *options)) / (2 * h) for e in h * np.eye(9)]
        assert_allclose(two_imu_start._slope(x, *options), np.stack(numeric, axis=1), atol=1e-6)  # rounding 1e-13 / h


# --- consistency where its assumptions hold ---

DRAWN = Noise(
    gyro_std=(0.0017, 0.002),
    accel_std=0.03,
    r_density=0.001,
    turn_density=0.002,
    angular_density=(3.0, 2.0),
)
STDS = np.repeat([0.003, 0.003, 0.01, 0.001, 0.001, 0.5, 0.5], 3)


def drawn(rng, n, dt=0.01):
    """Run the filter on samples of its own model; its innovations (n,), last error (21,) and last P.

    The specific force at the joint centre is anything: gravity and a walk's acceleration in sensor 1 here.
    """
    x = np.concatenate([0.15 * rng.normal(size=6), np.zeros(3), rng.normal(size=6), 5 * rng.normal(size=6)])
    R = rotations.to_matrix(rotations.random(rng))
    f = TwoImuCentre(replace(DRAWN, r_std=1.0))
    start = STDS * rng.normal(size=STATES)
    f.start(*displaced(x, R, start), np.diag(STDS**2), np.zeros((2, 2, 3)), dt)
    Q = DRAWN.process(np.multiply.outer(np.square(DRAWN.angular_density), np.eye(3)), dt)
    root = np.linalg.cholesky(Q + 1e-30 * np.eye(STATES))
    squares = []
    for k in range(n):
        x, R, _ = predict(x, R, dt)
        x, R = displaced(x, R, root @ rng.normal(size=STATES))
        centre = np.array([3 * np.sin(0.12 * k), 9.8, np.cos(0.06 * k)])
        f1 = centre - two_imu_model.lever(x[W1], x[A1]) @ x[R1]
        f2 = R.T @ centre - two_imu_model.lever(x[W2], x[A2]) @ x[R2]
        noise = rng.normal(size=(2, 3)) * DRAWN.accel_std / np.sqrt(2)
        gyro = np.stack([x[W1], x[W2]]) + rng.normal(size=(2, 3)) * np.array(DRAWN.gyro_std)[:, None]
        f.advance(gyro, np.stack([f1, f2]) + noise, dt)
        squares.append(f.innovation_squared)
    return np.array(squares), apart(f.x, f.R, x, R), f.P


def test_innovations_and_errors_are_as_large_as_it_says(monkeypatch):
    # The linear filter is judged; that it trusts false information less is another matter, judged below.
    monkeypatch.setattr(two_imu_centre, "BLOCK", 10**9)
    rng = np.random.default_rng(3)
    runs, n = 60, 100
    outcomes = [drawn(rng, n) for _ in range(runs)]
    innovations = np.array([o[0] for o in outcomes]) / 9
    # chi-square / 9 over 60 x 100 independent samples: 1 +- 0.006; linearisation may cost twice as much again
    assert 0.98 < innovations.mean() < 1.02
    squares = np.array([e @ np.linalg.solve(P, e) for _, e, P in outcomes]) / STATES
    assert 0.84 < squares.mean() < 1.16  # 60 runs of chi-square / 21: 1 +- 0.040, four of these


def test_the_drift_of_the_angular_acceleration_is_that_of_the_motion():
    rng = np.random.default_rng(4)
    step, std = 0.01, 0.0017
    time = np.arange(3000) * step
    w = np.zeros((2, 3000, 3))
    w[0, :, 1] = 2 * np.sin(2 * np.pi * 1.5 * time)  # w'' of 2 (2 pi 1.5)^2 = 178 rad/s^3, 126 RMS, about y
    noisy = w + std * rng.normal(size=w.shape)
    jerk = two_imu_model.Jerk(Noise(gyro_std=(std, std)), noisy[:, :100], step)
    powers = np.mean([jerk.powers(noisy[:, k], step) for k in range(100, 3000)], axis=0)
    assert_allclose(np.sqrt(powers[0, 1, 1] / step), 126, rtol=0.03)  # 1 s is one and a half periods
    assert powers[0, 0, 0] < 0.1 * powers[0, 1, 1]
    rest = 6 * std**2 / step**4 * step  # what the noise of a sensor at rest would make of it
    assert np.trace(powers[1]) < 3 * 0.5 * rest


def test_a_wrong_sign_is_noticed(monkeypatch):
    def wrong(x, R, accel1, accel2):
        c, H = constraint(x, R, accel1, accel2)
        H[:, TURN] *= -1
        return c, H

    monkeypatch.setattr(two_imu_centre, "constraint", wrong)
    squares, _, _ = drawn(np.random.default_rng(3), 100)
    assert squares.mean() / 9 > 2.0


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


# --- what a motion does not show ---


def test_a_hinge_hides_one_direction_and_no_other():
    squares = []
    for seed in range(3):
        recording, truth = simulate("hinge-gait", seed)
        answer = find("two-imu-centre").estimate(recording)
        error, along = across(answer, truth)
        assert np.abs(error).max() < 0.002  # 0.5 mm measured
        hidden = np.sqrt(np.einsum("i,nij,j->n", along, answer.covariance, along))
        assert np.median(hidden) > 0.25  # as sure as before any sample: 0.3 m, but for a tenth of the time, 0.05
        assert abs(along @ answer.value[-1].ravel()) < 0.02  # nearest both sensors, as Seel 2012 has it
        values, vectors_ = np.linalg.eigh(answer.covariance[-1])
        squares += list((vectors_[:, :5].T @ error) ** 2 / values[:5])
    assert np.mean(squares) < 2.0  # a filter on a motion that is no random walk; 0.3 measured


def test_near_a_plane_it_is_less_sure():
    recording, truth = simulate("hinge-walking", 0)
    answer = estimate(recording)
    error, _ = across(answer, truth)
    assert np.linalg.norm(error) < 0.01
    assert np.sqrt(np.linalg.eigvalsh(answer.covariance[-1])[4]) > 3e-4


def test_a_pelvis_that_rests_shows_nothing_of_itself():
    recording, truth = hip(0, motions=(pelvis(scale=0.0), ellipse()))
    answer = estimate(recording)
    _, two = errors(answer, truth)
    assert two < 0.001
    assert np.sqrt(np.linalg.eigvalsh(answer.covariance[-1][:3, :3])[0]) > 0.25  # 0.3 m before any sample
    assert np.sqrt(np.linalg.eigvalsh(answer.covariance[-1][3:, 3:])[-1]) < 0.002


@pytest.mark.parametrize("noise", [(0.0, 0.0), (0.0017, 0.02)])
def test_motion_without_information_is_called_so(noise):
    rng = np.random.default_rng(4)
    time = np.arange(400) / 100
    imus = tuple(
        Imu(
            f"imu{i + 1}",
            time,
            noise[0] * rng.normal(size=(400, 3)),
            rotations.rotate_back(rotations.random(rng), np.tile([0, 0, 9.81], (400, 1)))
            + noise[1] * rng.normal(size=(400, 3)),
            100.0,
        )
        for i in range(2)
    )
    answer = estimate(Recording("still", "hinge", imus))
    assert answer.status == "not identifiable"
    assert answer.covariance is None


def test_a_locked_hinge_is_not_identified():
    assert estimate(simulate("hinge-locked", 0)[0]).status == "not identifiable"


@dataclass(frozen=True)
class Later:
    """A signal that sets in smoothly at `start` s."""

    signal: Callable
    start: float

    def __call__(self, time):
        t = np.clip(time - self.start, 0.0, None)
        value, first, second = self.signal(t)
        left = np.exp(-(t**3))
        r, dr, ddr = 1 - left, 3 * t**2 * left, (6 * t - 9 * t**4) * left
        return r * value, dr * value + r * first, ddr * value + 2 * dr * first + r * second


def test_it_learns_later_what_a_motion_shows_later():
    """Six seconds in a plane, then out of it: r along the axis of flexion, unseen at first, is found."""
    flexion = Sines([0.35, 0.1], [0.95, 1.7])
    both = (
        replace(pelvis(), heading=STILL, tilt=STILL, spin=Sines(0.3, 0.8)),
        replace(ellipse(), heading=Later(Sines(0.3, 1.1), 6.0), tilt=Later(Sines(0.3, 0.9), 6.0), spin=flexion),
    )
    recording, _ = hip(0, motions=both, duration=14.0)
    answer = estimate(recording)
    row = np.searchsorted(answer.time, 5.9)
    assert answer.covariance[row, 4, 4] > 0.1**2  # r_2 along y, with the thigh's sensor unturned
    assert np.sqrt(answer.covariance[-1, 4, 4]) < 0.003
    assert np.linalg.norm(answer.value[-1, 1] - R_TEXT) < 0.003


def test_it_waits_while_both_segments_rest():
    rng = np.random.default_rng(7)
    mounts, centre = hip_mounts(rng), {k: Later(v, 3.0) for k, v in gait(rng).items()}
    turning = [
        replace(m, **{k: Later(getattr(m, k), 3.0) for k in ("heading", "tilt", "spin")}) for m in (pelvis(), ellipse())
    ]
    truth = shared_centre(tuple(turning), mounts, centre, 9.0)
    answer = estimate(observe(truth, IMU, rng))
    assert 3.0 < answer.time[0] < 4.0
    one, two = errors(answer, truth, after=6.0)
    assert one < 0.005  # 1.5 mm of 20 seeds at 6 s, 4 mm the worst
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
