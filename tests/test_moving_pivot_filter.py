"""The filter of two IMUs: its Jacobians, and errors as large as it says."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from imubench import rotations
from imubench.estimators import two_imu_centre, two_imu_model, two_imu_start
from imubench.estimators.two_imu_centre import TwoImuCentre
from imubench.estimators.two_imu_model import A1, A2, R1, R2, STATES, TURN, W1, W2, Noise, constraint, predict, turn
from imubench.scenarios.moving_pivot import gait, hip_mounts, pelvis, shared_centre
from imubench.scenarios.pendulum import ellipse

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


def test_the_covariance_stays_symmetric_and_positive_on_a_long_stream():
    """Without it the asymmetry of rounding doubled every few seconds, and after minutes the filter was lost."""
    rng = np.random.default_rng(0)
    truth = shared_centre((pelvis(), ellipse()), hip_mounts(rng), gait(rng), 10.0, 100.0)
    one, two = truth.sensors
    centre = TwoImuCentre()
    for k in range(one.gyro.shape[0]):
        gyro = np.stack([one.gyro[k], two.gyro[k]]) + 0.002 * rng.normal(size=(2, 3))
        centre.update(gyro, np.stack([one.specific_force[k], two.specific_force[k]]), 0.01)
    assert_array_equal(centre.P, centre.P.T)
    assert np.linalg.eigvalsh(centre.P)[0] > 0
