"""A recursive filter with the slide in its state, as the other way to stream: an extended Kalman filter, or a bank.

State: r0, s, s', log W, w, w', with r = r0 + s and s'' = -W^2 s, one frequency for all axes. w' is a random walk.
Measured are w and a = W^2 s - 2 w x s' - (w' x r + w x (w x r)), r' and r'' of the sensor's own motion in it. W is far
from linear, so filters start from several, and the one answers whose samples were the most probable so far.
It follows one felt slide; docs/soft-tissue.md has it beside `sliding-stream`, which is better.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array, frozen
from imubench.errors import InputError
from imubench.estimators.centre_ekf import linearise

R_, S_, V_, Q_, W_, A_ = slice(0, 3), slice(3, 6), slice(6, 9), 9, slice(10, 13), slice(13, 16)
STATES = 16
STARTS = (0.3, 0.5, 0.8, 1.2, 2.0, 3.0, 4.5)  # Hz
SLIDE_STD, R_STD, LOG_STD, ANGULAR_STD = 0.02, 0.15, 0.2, 10.0  # m, m, -, rad/s^2
ANGULAR_DENSITY, SPEED_DENSITY = 5.2, 1e-3  # rad/s^2/sqrt(s), as for ArVE_d; m/s/sqrt(s)


def _skew(x: Array) -> Array:
    a, b, c = x.tolist()
    return np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])


def predicted(x: Array, dt: float) -> tuple[Array, Array]:
    """Return the state `dt` s later and its Jacobian (16, 16)."""
    turn = math.exp(x[Q_])
    c, k = math.cos(turn * dt), math.sin(turn * dt)
    s, v = x[S_], x[V_]
    y, F = x.copy(), np.eye(STATES)
    eye = np.eye(3)
    y[S_], y[V_] = c * s + k / turn * v, -turn * k * s + c * v
    y[W_] += dt * x[A_]
    F[S_, S_], F[S_, V_], F[V_, S_], F[V_, V_] = c * eye, k / turn * eye, -turn * k * eye, c * eye
    F[S_, Q_] = turn * (-dt * k * s + (dt * c / turn - k / turn**2) * v)
    F[V_, Q_] = turn * (-(k + turn * dt * c) * s - dt * k * v)
    F[W_, A_] = dt * eye
    return y, F


def measured(x: Array) -> tuple[Array, Array]:
    """Return w and a (6,) of a state, and the Jacobian (6, 16)."""
    square = math.exp(2 * x[Q_])
    s, v, w = x[S_], x[V_], x[W_]
    rows, a = linearise([*(x[R_] + s).tolist(), *w.tolist(), *x[A_].tolist()])
    lever = np.array(rows)
    H = np.zeros((6, STATES))
    H[:3, W_] = np.eye(3)
    H[3:, R_], H[3:, S_], H[3:, V_] = lever[:, :3], lever[:, :3] + square * np.eye(3), -2 * _skew(w)
    H[3:, Q_] = 2 * square * s
    H[3:, W_], H[3:, A_] = lever[:, 3:6] + 2 * _skew(v), lever[:, 6:9]
    return np.concatenate([w, np.array(a) + square * s - 2 * np.cross(w, v)]), H


class SlidingFilter:
    """One filter from one frequency in Hz: one sample in, one r out."""

    def __init__(self, frequency: float, gyro_noise_std: float = 0.0017, accel_noise_std: float = 0.02):
        turn = 2 * np.pi * frequency
        self.x, self.turn = np.zeros(STATES), turn
        self.x[Q_] = np.log(turn)
        slide, speed = np.full(3, SLIDE_STD), np.full(3, SLIDE_STD * turn)
        angular = np.full(3, ANGULAR_STD)
        std = [np.full(3, R_STD), slide, speed, np.array([LOG_STD]), np.full(3, gyro_noise_std), angular]
        self.P = np.diag(np.concatenate(std) ** 2)
        self.R = np.diag(np.repeat([gyro_noise_std**2, accel_noise_std**2], 3))
        self.log_likelihood = 0.0
        self._started = False

    def update(self, gyro: ArrayLike, acceleration: ArrayLike, dt: float) -> Array:
        """Return r (3,) in m after w (3,) in rad/s and a (3,) in m/s^2, `dt` s after the sample before."""
        w, a = frozen(gyro, (3,), "gyro"), frozen(acceleration, (3,), "acceleration")
        if not self._started:
            self.x[W_], self._started = w, True
            return np.asarray(self.x[R_] + self.x[S_])
        if not dt > 0:
            raise InputError(f"sliding filter: expected a time step > 0 s, got {dt!r}")
        x, F = predicted(self.x, dt)
        P = F @ self.P @ F.T
        P[A_, A_] += ANGULAR_DENSITY**2 * dt * np.eye(3)
        P[V_, V_] += SPEED_DENSITY**2 * dt * np.eye(3)
        h, H = measured(x)
        HP = H @ P
        S = HP @ H.T + self.R
        e = np.concatenate([w, a]) - h
        gain = np.linalg.solve(S, HP).T
        self.log_likelihood -= 0.5 * float(e @ np.linalg.solve(S, e) + np.linalg.slogdet(S)[1])
        self.x = x + gain @ e
        P = P - gain @ HP
        self.P = (P + P.T) / 2
        return np.asarray(self.x[R_] + self.x[S_])


class SlidingBank:
    """Filters from several frequencies; the most probable so far answers."""

    def __init__(self, starts: Sequence[float] = STARTS, gyro_noise_std: float = 0.0017, accel_noise_std: float = 0.02):
        self.filters = [SlidingFilter(f, gyro_noise_std, accel_noise_std) for f in starts]

    def update(self, gyro: ArrayLike, acceleration: ArrayLike, dt: float) -> Array:
        """Return r (3,) in m after w (3,) in rad/s and a (3,) in m/s^2, `dt` s after the sample before."""
        answers = [one.update(gyro, acceleration, dt) for one in self.filters]
        return answers[int(np.argmax([one.log_likelihood for one in self.filters]))]
