"""Both joint vectors and the relative orientation from the first samples of two IMUs, by least squares.

With Q_i the turn of sensor i since the first sample, from its gyroscope, and C the orientation of sensor 2 in sensor 1
at the first sample, the specific force at the joint centre is the same in both (docs/moving-pivot.md):

    Q_1 (f_1 + K_1 r_1) - C Q_2 (f_2 + K_2 r_2) = 0,    K r = w' x r + w x (w x r)

over r_1, r_2 and C together. C starts where the mean forces agree, with eight headings about them.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from imubench import rotations
from imubench.arrays import Array
from imubench.estimators.mrvs import central_difference, lever_matrix
from imubench.estimators.two_imu_model import turn

HEADINGS = 8  # starts about the mean force
CAREFUL = 2.0  # times the information about r that noise in w' alone makes: 1 sometimes let a hinge seem seen along
HEADING_STD = 1.0  # rad; the largest std that a linear filter is told of an orientation


@dataclass(frozen=True)
class Start:
    """What the first samples say, at the last of them."""

    r: Array  # (6,) m, both vectors
    quaternion: Array  # (4,) sensor 2 -> sensor 1
    covariance: Array  # (9, 9) of r and of a rotation vector on the left of the quaternion, sensor 1 axes
    residual_std: float  # m/s^2


def turns(gyro: Array, time: Array) -> Array:
    """Return the orientations (n, 4) of a sensor in its first axes, from rates (n, 3), by the mean of two at a time."""
    steps = rotations.exp((gyro[1:] + gyro[:-1]) / 2 * np.diff(time)[:, None])
    q = np.empty((len(gyro), 4))
    q[0] = [1.0, 0.0, 0.0, 0.0]
    for k, step in enumerate(steps):
        q[k + 1] = rotations.multiply(q[k], step)
    return q


def start(
    gyro: Array, accel: Array, time: Array, r_std: float, noise_std: float, gyro_std: tuple[float, float]
) -> Start:
    """Fit rates in rad/s and specific forces in m/s^2, (2, n, 3) at `time` (n,) s; r is 0 give or take `r_std` m.

    `noise_std` in m/s^2 is that of the residual with nothing but sensor noise; what a fit leaves is no less.
    """
    q = np.stack([turns(w, time) for w in gyro])
    Q = rotations.to_matrix(q)[:, 1:-1]
    levers = Q @ np.stack([lever_matrix(w[1:-1], central_difference(w, time)) for w in gyro])
    forces = (Q @ accel[:, 1:-1, :, None])[..., 0]
    best = None
    for first in _headings(*forces.mean(axis=1)):
        fit = least_squares(_residual, np.zeros(9), _slope, x_scale=0.1, args=(forces, levers, first, r_std, noise_std))
        if best is None or fit.cost < best[0].cost:
            best = fit, first
    assert best is not None
    fit, first = best
    samples = _residual(fit.x, forces, levers, first, r_std, noise_std)[:-9] * noise_std
    scale = max(float(np.sqrt(np.mean(samples**2))), noise_std)
    slope = fit.jac.copy()
    slope[:-9] *= noise_std / scale
    angular = np.repeat(gyro_std, 3) / np.sqrt(2.0) / float(np.median(np.diff(time)))  # rad/s^2, of central differences
    prior = np.repeat([r_std, HEADING_STD], [6, 3])
    information = slope.T @ slope
    information[:6, :6] -= np.diag(CAREFUL * (len(time) - 2) * 2 * (angular / scale) ** 2)
    values, vectors = np.linalg.eigh(information * np.outer(prior, prior))
    covariance = (vectors / np.maximum(values, 1.0)) @ vectors.T * np.outer(prior, prior)
    C = rotations.multiply(rotations.exp(fit.x[6:]), first)
    now = np.eye(9)  # an error of C is on its left in the first axes of sensor 1; they have turned since
    now[6:, 6:] = rotations.to_matrix(q[0, -1]).T
    quaternion = rotations.multiply(rotations.multiply(rotations.conjugate(q[0, -1]), C), q[1, -1])
    covariance = now @ covariance @ now.T
    return Start(fit.x[:6], quaternion, covariance, scale)


def _headings(one: Array, two: Array) -> Array:
    """Return the orientations (8, 4) that turn the direction of `two` (3,) into that of `one`."""
    u, v = one / np.linalg.norm(one), two / np.linalg.norm(two)
    axis = np.cross(v, u)
    if np.linalg.norm(axis) < 1e-9:  # alike, or opposite: any axis across will do
        axis = np.cross(u, np.eye(3)[np.argmin(np.abs(u))])
    tilt = rotations.from_axis_angle(axis / np.linalg.norm(axis), rotations.angle_between(v, u))
    return rotations.multiply(rotations.from_axis_angle(u, 2 * np.pi * np.arange(HEADINGS) / HEADINGS), tilt)


def _carried(x: Array, forces: Array, levers: Array, first: Array) -> tuple[Array, Array]:
    """Return the forces at the joint centre (2, n, 3), both in the first axes of sensor 1, and C."""
    C = rotations.to_matrix(rotations.multiply(rotations.exp(x[6:]), first))
    carried = forces + np.einsum("inab,ib->ina", levers, x[:6].reshape(2, 3))
    carried[1] = carried[1] @ C.T
    return carried, C


def _residual(x: Array, forces: Array, levers: Array, first: Array, r_std: float, noise_std: float) -> Array:
    one, two = _carried(x, forces, levers, first)[0]
    return np.concatenate([((one - two) / noise_std).ravel(), x / np.repeat([r_std, HEADING_STD], [6, 3])])


def _slope(x: Array, forces: Array, levers: Array, first: Array, r_std: float, noise_std: float) -> Array:
    (_, two), C = _carried(x, forces, levers, first)
    turned = np.zeros((*two.shape, 3))  # d(-C u)/d(angle on the left of C) = [C u]x
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        turned[:, k, j], turned[:, j, k] = two[:, i], -two[:, i]
    on_the_left = turned @ turn(-x[6:])[1]  # the right Jacobian of -v is the left one of v
    rows = np.concatenate([levers[0], -C @ levers[1], on_the_left], axis=-1).reshape(-1, 9) / noise_std
    return np.concatenate([rows, np.diag(1 / np.repeat([r_std, HEADING_STD], [6, 3]))])
