"""A recursive filter with the slide in its state, as the other way to stream: an extended Kalman filter, or a bank.

State: r0, s, s', log W, w, w', with r = r0 + s and s'' = -W^2 s, one frequency for all axes. w' is a random walk.
Measured are w and a = W^2 s - 2 w x s' - (w' x r + w x (w x r)), r' and r'' of the sensor's own motion in it. W is far
from linear, so filters start from several, and the one answers whose samples were the most probable so far.
It follows one felt slide; docs/soft-tissue.md has it beside `sliding-stream`, which is better.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array, frozen
from imubench.errors import InputError

R_, S_, V_, Q_, W_, A_ = slice(0, 3), slice(3, 6), slice(6, 9), 9, slice(10, 13), slice(13, 16)
STATES = 16
STARTS = (0.3, 0.5, 0.8, 1.2, 2.0, 3.0, 4.5)  # Hz
SLIDE_STD, R_STD, LOG_STD, ANGULAR_STD = 0.02, 0.15, 0.2, 10.0  # m, m, -, rad/s^2
ANGULAR_DENSITY, SPEED_DENSITY = 5.2, 1e-3  # rad/s^2/sqrt(s), as for ArVE_d; m/s/sqrt(s)
EYE = np.eye(3)
CROSS = np.array(
    [[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0]]], float
)


def _skew(x: Array) -> Array:
    """Return [x]x (..., 3, 3) of x (..., 3)."""
    return np.asarray((x @ CROSS.reshape(3, 9)).reshape(*x.shape, 3))


def predicted(x: Array, dt: float) -> tuple[Array, Array]:
    """Return the states (..., 16) `dt` s later and their Jacobians (..., 16, 16)."""
    turn = np.exp(x[..., Q_, None])
    c, k = np.cos(turn * dt), np.sin(turn * dt)
    s, v = x[..., S_], x[..., V_]
    y, F = x.copy(), np.broadcast_to(np.eye(STATES), (*x.shape, STATES)).copy()
    y[..., S_], y[..., V_] = c * s + k / turn * v, -turn * k * s + c * v
    y[..., W_] += dt * x[..., A_]
    F[..., S_, S_] = F[..., V_, V_] = c[..., None] * EYE
    F[..., S_, V_], F[..., V_, S_] = (k / turn)[..., None] * EYE, (-turn * k)[..., None] * EYE
    F[..., S_, Q_] = turn * (-dt * k * s + (dt * c / turn - k / turn**2) * v)
    F[..., V_, Q_] = turn * (-(k + turn * dt * c) * s - dt * k * v)
    F[..., W_, A_] = dt * EYE
    return y, F


def measured(x: Array) -> tuple[Array, Array]:
    """Return w and a (..., 6) of states (..., 16), and the Jacobians (..., 6, 16)."""
    square = np.exp(2 * x[..., Q_, None])
    r, s, v, w = x[..., R_] + x[..., S_], x[..., S_], x[..., V_], x[..., W_]
    cross_w, cross_r = _skew(w), _skew(r)
    lever = -_skew(x[..., A_]) - cross_w @ cross_w
    h, H = np.empty((*x.shape[:-1], 6)), np.zeros((*x.shape[:-1], 6, STATES))
    h[..., :3] = w
    h[..., 3:] = (lever @ r[..., None])[..., 0] + square * s - 2 * (cross_w @ v[..., None])[..., 0]
    H[..., :3, W_] = EYE
    H[..., 3:, R_], H[..., 3:, S_], H[..., 3:, V_] = lever, lever + square[..., None] * EYE, -2 * cross_w
    H[..., 3:, Q_] = 2 * square * s
    along = np.sum(w * r, axis=-1)[..., None, None] * EYE
    H[..., 3:, W_] = 2 * r[..., :, None] * w[..., None, :] - w[..., :, None] * r[..., None, :] - along + 2 * _skew(v)
    H[..., 3:, A_] = cross_r
    return h, H


class SlidingBank:
    """Filters from several frequencies side by side; the most probable so far answers."""

    def __init__(self, starts: Sequence[float] = STARTS, gyro_noise_std: float = 0.0017, accel_noise_std: float = 0.02):
        turn = 2 * np.pi * np.asarray(starts, dtype=float)
        count = turn.size
        self.x = np.zeros((count, STATES))
        self.x[:, Q_] = np.log(turn)
        std = np.empty((count, STATES))
        std[:, R_], std[:, S_], std[:, V_], std[:, Q_] = R_STD, SLIDE_STD, SLIDE_STD * turn[:, None], LOG_STD
        std[:, W_], std[:, A_] = gyro_noise_std, ANGULAR_STD
        self.P = std[:, :, None] ** 2 * np.eye(STATES)
        self.R = np.diag(np.repeat([gyro_noise_std**2, accel_noise_std**2], 3))
        self.log_likelihood = np.zeros(count)
        self._started = False

    def update(self, gyro: ArrayLike, acceleration: ArrayLike, dt: float) -> Array:
        """Return r (3,) in m after w (3,) in rad/s and a (3,) in m/s^2, `dt` s after the sample before."""
        w, a = frozen(gyro, (3,), "gyro"), frozen(acceleration, (3,), "acceleration")
        if not self._started:
            self.x[:, W_], self._started = w, True
            return self._answer()
        if not dt > 0:
            raise InputError(f"sliding filter: expected a time step > 0 s, got {dt!r}")
        x, F = predicted(self.x, dt)
        P = F @ self.P @ np.swapaxes(F, 1, 2)
        P[:, A_, A_] += ANGULAR_DENSITY**2 * dt * EYE
        P[:, V_, V_] += SPEED_DENSITY**2 * dt * EYE
        h, H = measured(x)
        HP = H @ P
        S = HP @ np.swapaxes(H, 1, 2) + self.R
        e = (np.concatenate([w, a]) - h)[..., None]
        solved = np.linalg.solve(S, np.concatenate([HP, e], axis=2))
        self.log_likelihood -= 0.5 * (np.sum(e * solved[..., -1:], axis=(1, 2)) + np.linalg.slogdet(S)[1])
        self.x = x + (np.swapaxes(HP, 1, 2) @ solved[..., -1:])[..., 0]
        P -= np.swapaxes(solved[..., :-1], 1, 2) @ HP
        self.P = (P + np.swapaxes(P, 1, 2)) / 2
        return self._answer()

    def _answer(self) -> Array:
        best = self.x[int(np.argmax(self.log_likelihood))]
        return np.asarray(best[R_] + best[S_])


class SlidingFilter(SlidingBank):
    """One filter from one frequency in Hz."""

    def __init__(self, frequency: float, gyro_noise_std: float = 0.0017, accel_noise_std: float = 0.02):
        super().__init__((frequency,), gyro_noise_std, accel_noise_std)
