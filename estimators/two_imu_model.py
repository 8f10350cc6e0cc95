"""State, prediction and measurement of the two-IMU filter of the joint centre (two_imu_centre.py).

Frames and signs are in docs/moving-pivot.md. The state has 21 numbers, each slice three, in the axes of its own sensor:
r_1, r_2 in m; theta in rad, the error of the relative orientation R = exp([theta]x) R_estimated, which takes vectors
from sensor 2 to sensor 1; w_1, w_2 in rad/s; w_1', w_2' in rad/s^2.
"""

import math
from dataclasses import dataclass, fields

import numpy as np

from imubench.arrays import Array
from imubench.recording import positive

STATES = 21
R1, R2, TURN, W1, W2, A1, A2 = (slice(k, k + 3) for k in range(0, STATES, 3))
EYE = np.eye(3)
GYRO_STD, ACCEL_STD = 0.002, 0.02  # rad/s, m/s^2 per sample, where nothing is declared

MEMORY = 1.0  # s, over which the drift of w' is watched


@dataclass(frozen=True)
class Noise:
    """What P0, Q and R are made of; densities are those of white noise that drives a random walk."""

    gyro_std: tuple[float, float] = (GYRO_STD, GYRO_STD)  # rad/s per sample, of either IMU
    accel_std: float = math.hypot(ACCEL_STD, ACCEL_STD)  # m/s^2 per sample, of both accelerometers together
    r_std: float = 0.3  # m, of r before any sample: a limb's length
    r_density: float = 0.0003  # m/sqrt(s): 1 mm in 10 s, so that it stays able to learn
    turn_density: float = 0.001  # rad/sqrt(s), of the relative orientation beside what the rates say
    angular_density: tuple[float, float] | None = None  # rad/s^2/sqrt(s), of w'; None: from the rates of late

    def __post_init__(self) -> None:
        for f in fields(self):
            values = getattr(self, f.name)
            for value in values if isinstance(values, tuple) else () if values is None else (values,):
                positive(value, f"noise.{f.name}", or_zero=f.name.endswith("density"))

    def process(self, powers: Array, dt: float) -> Array:
        """Return Q (21, 21) of a step of `dt` s, w' driven by white noise of `powers` (2, 3, 3), density squared."""
        Q = np.zeros((STATES, STATES))
        Q[:6, :6] = self.r_density**2 * dt * np.eye(6)
        Q[TURN, TURN] = self.turn_density**2 * dt * EYE
        for w, a, power in ((W1, A1, powers[0]), (W2, A2, powers[1])):
            Q[w, w], Q[a, a] = power * (dt**3 / 3), power * dt
            Q[w, a] = Q[a, w] = power * (dt**2 / 2)
        return Q

    def measurement(self) -> Array:
        """Return the variances (9,) of both rates and of c."""
        return np.repeat(np.square([*self.gyro_std, self.accel_std]), 3)


class Jerk:
    """How w' drifts: the mean of w'' w''^T over about the last second, from second differences of the rates.

    White noise of this power, times the step, has w' keep up with w'' from one sample to the next. The noise of the
    gyroscopes is taken out; a tenth of it, and a hundredth of the largest direction, may hide in any direction.
    """

    def __init__(self, noise: Noise, rates: Array, step: float):
        self.noise, self._last = noise, rates[:, -2:]
        second = np.diff(rates, 2, axis=1) / step**2
        self._mean = np.einsum("ina,inb->iab", second, second) / max(second.shape[1], 1)  # (2, 3, 3)

    def powers(self, gyro: Array, dt: float) -> Array:
        """Return the powers (2, 3, 3) in (rad/s^2)^2/s after rates (2, 3) in rad/s, `dt` s after those before."""
        if self.noise.angular_density is not None:
            return np.multiply.outer(np.square(self.noise.angular_density), EYE)
        second = (gyro - 2 * self._last[:, 1] + self._last[:, 0]) / dt**2
        self._last = np.stack([self._last[:, 1], gyro], axis=1)
        part = min(dt / MEMORY, 1.0)
        self._mean = (1 - part) * self._mean + part * second[:, :, None] * second[:, None, :]
        noise = 6 * np.square(self.noise.gyro_std)[:, None] / dt**4
        sizes, axes = np.linalg.eigh(self._mean)
        sizes = np.maximum(sizes - noise, np.maximum(noise / 10, sizes[:, 2:] / 100))
        return dt * (axes * sizes[:, None, :]) @ axes.transpose(0, 2, 1)


def skew(v: Array) -> Array:
    """Return [v]x (3, 3)."""
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turn(s: Array) -> tuple[Array, Array]:
    """Return exp([s]x) and its right Jacobian J, both (3, 3): exp([s + d]x) = exp([s]x) exp([J d]x) for small d."""
    angle, x = math.sqrt(s.dot(s)), skew(s)
    square = x.dot(x)
    if angle < 1e-4:
        sine, cosine, rest = 1.0, 0.5, 1 / 6
    else:
        sine, cosine = math.sin(angle) / angle, (1 - math.cos(angle)) / angle**2
        rest = (1 - sine) / angle**2
    return EYE + sine * x + cosine * square, EYE - cosine * x + rest * square


def predict(x: Array, R: Array, dt: float) -> tuple[Array, Array, Array]:
    """Return state, R and F (21, 21) after `dt` s: each sensor turns by s = (w + w' dt / 2) dt.

    R+ = exp(-s_1) R exp(s_2), so theta+ = exp(-s_1) theta - J(s_1) ds_1 + R+ J(s_2) ds_2, J the right Jacobian.
    """
    (E1, J1), (E2, J2) = (turn((x[w] + x[a] * (dt / 2)) * dt) for w, a in ((W1, A1), (W2, A2)))
    R = E1.T.dot(R).dot(E2)
    F = np.eye(STATES)
    F[TURN, TURN] = E1.T
    for w, a, J in ((W1, A1, -J1), (W2, A2, R.dot(J2))):
        F[TURN, w], F[TURN, a] = J * dt, J * (dt**2 / 2)
        F[w, a] = dt * EYE
    return F.dot(x), R, F


def lever(w: Array, a: Array) -> Array:
    """Return K (3, 3) of one sample; `mrvs.lever_matrix` is that of many."""
    return np.outer(w, w) - w.dot(w) * EYE + skew(a)


def constraint(x: Array, R: Array, accel1: Array, accel2: Array) -> tuple[Array, Array]:
    """Return c (3,) in m/s^2 and its derivative (3, 21) by the state; theta is zero, R (3, 3) is where it is.

    c = f_1 + K_1 r_1 - R (f_2 + K_2 r_2). dc/dr_1 = K_1, dc/dw_1' = -[r_1]x, dc/dw_1 = w r^T + (w.r) I - 2 r w^T;
    those of sensor 2 times -R; dc/dtheta = [R (f_2 + K_2 r_2)]x.
    """
    H = np.zeros((3, STATES))
    K1, K2 = lever(x[W1], x[A1]), lever(x[W2], x[A2])
    u = R.dot(accel2 + K2.dot(x[R2]))
    H[:, R1], H[:, R2] = K1, -R.dot(K2)
    H[:, TURN] = skew(u)
    H[:, W1], H[:, W2] = _by_rate(x[R1], x[W1]), -R.dot(_by_rate(x[R2], x[W2]))
    H[:, A1], H[:, A2] = -skew(x[R1]), R.dot(skew(x[R2]))
    return accel1 + K1.dot(x[R1]) - u, H


def _by_rate(r: Array, w: Array) -> Array:
    return np.outer(w, r) - 2 * np.outer(r, w) + w.dot(r) * EYE
