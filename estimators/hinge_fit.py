"""The least-squares fit of the hinge constraints by Gauss-Newton with backtracking, and its covariance.

The core of Olsson 2020, section 4, and, without accelerometer samples, of Seel 2012.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from imubench.arrays import Array
from imubench.estimators.hinge_constraints import Constraints
from imubench.estimators.rice import expected_length
from imubench.estimators.spherical import chart, coordinates, turn

MAX_ITERATIONS = 200
STEP_TOLERANCE = 1e-11  # rad; a step this short is below what any sensor resolves
SUFFICIENT_DECREASE = 1e-4  # Armijo's constant (Nocedal and Wright, section 3.1)
SLOW = 0.5  # a step that lowers the cost by less than this part asks for second derivatives
RIDGE = 1e-12  # smallest part of its trace that an eigenvalue of the Hessian is taken to be
CONE = 1e-9  # |w x j| / |w . j| below which the direction of w x j is only rounding
TINY_RATE = 1e-75  # rad/s, weighted: keeps the noise of a sensor at rest above 0
_TINY = 1e-300  # keeps 0 / 0 at 0 where w x j vanishes; far below any rounding of the rest


@dataclass(frozen=True, slots=True)
class Solution:
    """A minimum of the weighted cost, with the information around it."""

    axes: Array  # (2, 3) unit vectors, each in its sensor's axes
    frames: Array  # (2, 3, 3) rows j, dj/dtheta, dj/dphi of the chart around the axes, orthonormal
    cost: float  # V of eq. (23)
    iterations: int
    converged: bool
    gyro_information: Array  # (4, 4) J^T J of the weighted gyroscope residuals
    accel_information: Array  # (4, 4) J^T J of the weighted accelerometer residuals
    gyro_std: float  # of the weighted residuals, eq. (58); 0 with fewer than 2 samples
    accel_std: float

    @property
    def tangents(self) -> Array:
        """The derivatives (2, 2, 3) of each axis by theta and phi of the chart around it."""
        return self.frames[:, 1:]

    @property
    def x(self) -> Array:
        """The spherical coordinates (4,) theta1, phi1, theta2, phi2 in rad."""
        return coordinates(self.axes)


def descend(c: Constraints, start: ArrayLike, tolerance: float = 1e-10) -> Solution:
    """Minimise the cost from `start` (4,) in rad by Gauss-Newton with backtracking (Olsson 2020, eq. 30).

    Stops when a step lowers the cost, or can be expected to, by less than `tolerance` times the cost,
    when no step lowers it, or when the cost is only rounding; `converged` is False after 200 iterations.
    """
    point = _evaluate(c, chart(start))
    converged, slow, iterations = point.cost <= c.floor, False, 0
    while not converged and iterations < MAX_ITERATIONS:
        step, slope = _step(point, slow)
        if slope <= tolerance * point.cost:  # by as much as the quadratic model says is left
            converged = True
            break
        length = float(np.abs(step).max())
        alpha = min(1.0, 0.5 * math.pi / length) if length > 0 else 0.0
        trial = point
        while alpha * length > STEP_TOLERANCE:
            trial = _evaluate(c, turn(point.frames, -alpha * step))
            if trial.cost <= point.cost - 2 * SUFFICIENT_DECREASE * alpha * slope:
                break
            trial, alpha = point, 0.5 * alpha
        drop = (point.cost - trial.cost) / point.cost
        slow, converged = drop < SLOW, bool(drop <= tolerance or trial.cost <= c.floor)
        point, iterations = trial, iterations + 1
    return _solution(c, point, iterations, converged)


@dataclass(frozen=True, slots=True)
class _Point:
    frames: Array  # (2, 3, 3) rows j, d/dtheta, d/dphi
    along: Array  # (b, 2, size) w . j
    across: Array  # (b, 2, 2, size) w . d/dtheta and w . d/dphi
    off_axis: Array  # (b, 2, size) |w x j|, without the cancellation of |w|^2 - (w . j)^2
    gyro: Array  # (b, size) weighted residuals, eq. (24)
    accel: Array  # (k,) residuals of the factor, the same sum of squares as eq. (25)
    accel_jacobian: Array  # (k, 4)
    cost: float


def _evaluate(c: Constraints, frames: Array) -> _Point:
    parts = frames @ c.rates
    across = parts[:, :, 1:]
    off_axis = np.sqrt(across[:, :, 0] ** 2 + across[:, :, 1] ** 2 + _TINY)
    gyro = off_axis[:, 0] - off_axis[:, 1]
    forces = c.forces @ frames.transpose(0, 2, 1)
    accel = forces[0, :, 0] + forces[1, :, 0]
    jacobian = np.concatenate([forces[0, :, 1:], forces[1, :, 1:]], axis=1)
    cost = float(np.sum(gyro * gyro) + accel @ accel)
    return _Point(frames, parts[:, :, 0], across, off_axis, gyro, accel, jacobian, cost)


def _gyro_gradients(p: _Point) -> Array:
    """Return the transposed Jacobian (b, 4, size) of the gyroscope residuals, but for the sign of sensor 1's rows.

    Eq. (37) projected on the tangents: (w x j) x w / |w x j| . t = -(w . j)(w . t) / |w x j|.
    """
    rows = p.across * (p.along / p.off_axis)[:, :, None]
    return np.asarray(rows.reshape(len(rows), 4, -1))


_SIGNS = np.array([-1.0, -1.0, 1.0, 1.0])


def _step(p: _Point, slow: bool) -> tuple[Array, float]:
    """Return the step (4,) to subtract and how fast V / 2 falls along it.

    Gauss-Newton's, or, where that is slow, Newton's with the second derivatives of eq. (33) that
    eq. (34) leaves out: in planar motion |w x j| is a cone near the truth, and they are not small.
    """
    rows = _gyro_gradients(p)
    gradient = _SIGNS * (rows @ p.gyro[:, :, None]).sum(axis=0)[:, 0] + p.accel_jacobian.T @ p.accel
    hessian = _outer(rows) + p.accel_jacobian.T @ p.accel_jacobian
    if slow:
        hessian += _curvature(p, rows)
        values, vectors = np.linalg.eigh(hessian)
        values = np.maximum(np.abs(values), RIDGE * float(np.abs(values).sum()) + _TINY)
        step = vectors @ ((gradient @ vectors) / values)
    else:
        ridge = RIDGE * float(np.trace(hessian)) + _TINY  # without it no step where J^T J is singular
        step = np.linalg.solve(hessian + ridge * np.eye(4), gradient)
    return step, float(gradient @ step)


def _outer(rows: Array) -> Array:
    """Return the gyroscope's part of J^T J (4, 4)."""
    return np.asarray(_SIGNS[:, None] * (rows @ rows.transpose(0, 2, 1)).sum(axis=0) * _SIGNS)


def _curvature(p: _Point, rows: Array) -> Array:
    """Return the sum of e d2e/dx2 (4, 4) over the gyroscope samples, eq. (33), to leading order in |w x j|.

    d2|w x j| / dx2 = ((w . j)^2 - g g^T) / |w x j| with the gradient g of |w x j|.
    """
    bend = p.gyro[:, None] / p.off_axis
    gradients = rows.reshape(len(rows), 2, 2, -1)
    blocks = ((gradients * bend[:, :, None]) @ gradients.transpose(0, 1, 3, 2)).sum(axis=0)
    along = np.sum(p.along**2 * bend, axis=(0, 2))
    curvature = np.zeros((4, 4))
    for i, sign in enumerate((1.0, -1.0)):
        curvature[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = sign * (along[i] * np.eye(2) - blocks[i])
    return curvature


def _solution(c: Constraints, p: _Point, iterations: int, converged: bool) -> Solution:
    rows, _, cone = _regular(p)
    axes = p.frames[:, 0] / np.linalg.norm(p.frames[:, 0], axis=1, keepdims=True)
    return Solution(
        axes=axes,
        frames=p.frames,
        cost=p.cost,
        iterations=iterations,
        converged=converged,
        gyro_information=_outer(rows) + cone,
        accel_information=p.accel_jacobian.T @ p.accel_jacobian,
        gyro_std=_std(float(p.gyro.sum()), float(np.sum(p.gyro * p.gyro)), c.gyro_count),
        accel_std=_std(float(np.vdot(c.force_sums, axes)), float(p.accel @ p.accel), c.accel_count),
    )


def _regular(p: _Point) -> tuple[Array, NDArray[np.bool_], Array]:
    """Return gradients (b, 4, size), kept samples (b, 2, size), and what the others add to J^T J (4, 4).

    Where |w x j| is only rounding its direction is arbitrary: the mean of the gradient's square over
    all directions, (w . j)^2 / 2, takes its place. Noise-free planar motion is all like that.
    """
    rows = _gyro_gradients(p)
    kept = p.off_axis >= CONE * np.abs(p.along)
    if kept.all():
        return rows, kept, np.zeros((4, 4))
    lost = 0.5 * np.sum(p.along**2 * ~kept, axis=(0, 2))
    return rows * kept.repeat(2, axis=1), kept, np.diag(lost.repeat(2))


def _std(total: float, squares: float, count: int) -> float:
    """Return the sample standard deviation (Olsson 2020, eq. 58) from the sums over `count` samples."""
    if count < 2:
        return 0.0
    return math.sqrt(max(squares - total * total / count, 0.0) / (count - 1))


def local_covariance(s: Solution) -> Array:
    """Return Olsson 2020's covariance (4, 4), eq. (57), in rad^2 of steps in the chart around the axes.

    It is that of the weights 1 / std; for any others it is too small (see `covariance`).
    Raises `numpy.linalg.LinAlgError` when the information is singular.
    """
    return np.asarray(np.linalg.inv(scaled_information(s)))


def scaled_information(s: Solution) -> Array:
    """Return J_s^T J_s (4, 4) of Olsson 2020, eq. (57): the information in units of the residuals' stds."""
    gyro, accel = max(s.gyro_std, 1e-100), max(s.accel_std, 1e-100)
    return s.gyro_information / gyro**2 + s.accel_information / accel**2


def covariance(c: Constraints, s: Solution) -> Array | None:
    """Return the covariance (4, 4) in rad^2 of steps in the chart around the axes; None if V has no minimum there.

    H^-1 S H^-1 with the covariance S of the gradient of V / 2 by the residuals' stds, eq. (58), and the
    expected Hessian H, eq. (33). With the weights 1 / std, and far from planar motion, it is eq. (57).
    """
    return spread(c, s, s.gyro_std**2 * s.gyro_information + s.accel_std**2 * s.accel_information)


def spread(c: Constraints, s: Solution, scores: Array) -> Array | None:
    """Return H^-1 S H^-1 (4, 4) in rad^2: how far the axes go if the gradient of V / 2 has the covariance `scores`."""
    hessian = _expected_hessian(_evaluate(c, s.frames), s.gyro_std) + s.accel_information
    values, vectors = np.linalg.eigh(hessian)
    if values[0] <= RIDGE * values[-1]:
        return None
    inverse = (vectors / values) @ vectors.T
    result = inverse @ scores @ inverse
    return np.asarray(0.5 * (result + result.T))


def _expected_hessian(p: _Point, std: float) -> Array:
    """Return the gyroscope's Hessian (4, 4) of V / 2, with |w x j| as long, steep and bent as it is on average.

    The second derivative of |w x j| goes with 1 / |w x j|. In planar motion w x j is noise, the variance of
    1 / |w x j| infinite, and where the minimum comes to lie, chance has made the sum too large: hence its
    expected value under noise of `std`, the residuals' (`rice`). docs/plug-and-play.md has the numbers.
    """
    std = max(std, CONE * float(np.abs(p.along).max(initial=0.0)), TINY_RATE)
    mean, along, across = expected_length(p.off_axis, std)
    unit = p.across / p.off_axis[:, :, None]
    slopes = unit * (p.along * across * p.off_axis)[:, :, None]  # of E|w x j|, by the axis
    hessian = _outer(slopes.reshape(len(slopes), 4, -1))  # sensor 1 by sensor 2; their own blocks follow
    for i in range(2):
        weight = p.along[:, i] ** 2
        other = weight * mean[:, 1 - i]
        round_part = float(np.sum(weight - other * across[:, i]))
        stretched = (unit[:, i] * (other * (across[:, i] - along[:, i]))[:, None]) @ unit[:, i].transpose(0, 2, 1)
        hessian[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = round_part * np.eye(2) + stretched.sum(axis=0)
    return hessian
