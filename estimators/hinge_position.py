"""The joint centre from two IMUs, by Seel et al. (CCA 2012) and Olsson and Halvorsen (Fusion 2017).

Carried to the joint centre, both accelerometers read the same specific force, each in its own axes. With r
from the sensor to the joint centre, in sensor axes,

    f_i = a_i + w_i' x r_i + w_i x (w_i x r_i),        e = |f_1| - |f_2| = 0,

which asks for no orientation, cancels whatever the joint centre does, and holds for every kind of joint. The
sum of e^2 is minimised over r_1 and r_2. A robust loss bounds what soft tissue and knocks can do
(Olsson and Halvorsen compare several; here Huber's).

A hinge leaves one direction open: both r_i may be moved along the hinge axis together, as any point of the axis
is as good a joint centre. The one nearest both sensors, r_1 . j_1 + r_2 . j_2 = 0, is returned (Seel 2012), and the
covariance carries `ALONG_STD` in that direction.
"""

import numpy as np
from scipy.optimize import least_squares

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.estimate import Estimate, Status
from imubench.estimators import olsson2020
from imubench.estimators.extent import too_short
from imubench.paired import Paired, paired
from imubench.recording import Recording

UNKNOWNS = 6  # r of either IMU
ALONG_STD = 0.1  # m; how far along its axis the middle of a hinge may lie from where this method puts it
HUBER = 1.345  # standard deviations; keeps 95 % of the efficiency on Gaussian residuals
SAME_DIRECTION = 0.98  # cosine between the least seen direction and the estimated hinge
REACH = 3.0  # m; a joint farther away than that has not been seen
STENCIL = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0  # first derivative, fourth order


def angular_acceleration(gyro: Array, period: float) -> Array:
    """Return w' (n - 4, 3) in rad/s^2 of rates (n, 3) sampled every `period` s, by the stencil of Seel 2012."""
    n = len(gyro)
    return sum(c * gyro[k : n - 4 + k] for k, c in enumerate(STENCIL) if c) / period


def lever_matrices(gyro: Array, angular: Array) -> Array:
    """Return K (n, 3, 3) with K r = w' x r + w x (w x r) (Olsson 2020, eq. 7)."""
    x, y, z = gyro.T
    dx, dy, dz = angular.T
    rows = [
        [-y * y - z * z, x * y - dz, x * z + dy],
        [x * y + dz, -x * x - z * z, y * z - dx],
        [x * z - dy, y * z + dx, -x * x - y * y],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def residuals(r: Array, accel: Array, levers: Array) -> tuple[Array, Array]:
    """Return e (n,) in m/s^2 and its derivative (n, 6) by the stacked vectors r (6,) in m.

    accel (2, n, 3) and levers (2, n, 3, 3) are those of both IMUs.
    """
    forces = accel + np.einsum("inab,ib->ina", levers, r.reshape(2, 3))
    norms = np.linalg.norm(forces, axis=-1)
    slopes = np.einsum("ina,inab->inb", forces / np.maximum(norms, 1e-12)[..., None], levers)
    return norms[0] - norms[1], np.concatenate([slopes[0], -slopes[1]], axis=1)


def estimate(recording: Recording) -> Estimate:
    """Estimate the IMU-to-joint vectors (2, 3) in m of a hinge rig.

    Raises `InputError` with fewer than two IMUs, or samples that are not evenly spaced.
    """
    samples = paired(recording)
    accel, levers, period = _prepared(samples)
    axes = olsson2020.estimate(recording)
    along = np.concatenate([axes.value[0], axes.value[1]]) / np.sqrt(2.0)
    scale, loss = 1.0, "linear"
    r = np.zeros(6)
    for _ in range(3):  # squares first, then Huber's loss at the scale that the squares left, then at its own
        fit = least_squares(
            lambda x: residuals(x, accel, levers)[0],
            r,
            jac=lambda x: residuals(x, accel, levers)[1],
            loss=loss,
            f_scale=HUBER * scale,
            x_scale=0.1,
        )
        r, loss = fit.x, "huber"
        scale = max(float(1.4826 * np.median(np.abs(residuals(r, accel, levers)[0]))), 1e-9)
    noise = [_gyro_noise(imu.gyro_noise_std, gyro) for imu, gyro in zip(recording.imus, _gyros(samples), strict=True)]
    angular_noise = np.array(noise) * np.sqrt(np.sum(STENCIL**2)) / period
    short = too_short(samples.time, UNKNOWNS)
    if short:
        return _unseen(r, short, {"samples": float(samples.time.size)})
    status: Status = "converged" if fit.success else "not converged"
    return _answer(r, along, accel, levers, scale, angular_noise, axes.status if axes.status != "converged" else status)


def _gyros(samples: Paired) -> tuple[Array, Array]:
    return samples.gyro1, samples.gyro2


def _gyro_noise(declared: float | None, gyro: Array) -> float:
    """Return the declared noise std in rad/s, or one from fourth differences, which hardly see motion."""
    if declared is not None:
        return declared
    return float(np.median(np.abs(np.diff(gyro, 4, axis=0))) * 1.4826 / np.sqrt(70.0))


def _prepared(samples: Paired) -> tuple[Array, Array, float]:
    """Return specific forces (2, n, 3), lever matrices (2, n, 3, 3) and the period in s, where samples are even."""
    steps = np.diff(samples.time)
    period = float(np.median(steps)) if steps.size else 0.0
    runs = np.abs(steps - period) < 0.05 * period
    even = runs[:-3] & runs[1:-2] & runs[2:-1] & runs[3:]
    if even.sum() < 20:
        raise InputError(
            f"hinge-position: expected evenly spaced samples of both IMUs, got {even.sum()} runs of five that are"
        )
    accel = np.stack([samples.accel1, samples.accel2])[:, 2:-2][:, even]
    levers = [lever_matrices(gyro[2:-2][even], angular_acceleration(gyro, period)[even]) for gyro in _gyros(samples)]
    return accel, np.stack(levers), period


def _answer(
    r: Array, along: Array, accel: Array, levers: Array, scale: float, angular_noise: Array, status: Status
) -> Estimate:
    """Return the estimate with its covariance.

    Noise of the differentiated gyroscope looks like motion: with n_i the direction of f_i it adds
    s_i^2 (1 - n n^T) a sample to the information about r_i, of which nothing is true. It is taken out;
    a direction in which little else is left has not been seen.
    """
    e, slope = residuals(r, accel, levers)
    weight = np.minimum(1.0, HUBER * scale / np.maximum(np.abs(e), 1e-12))
    information = (slope * weight[:, None]).T @ slope
    forces = accel + np.einsum("inab,ib->ina", levers, r.reshape(2, 3))
    n = forces / np.linalg.norm(forces, axis=-1, keepdims=True)
    false = np.zeros((6, 6))
    for i, block in enumerate((slice(0, 3), slice(3, 6))):
        false[block, block] = angular_noise[i] ** 2 * np.einsum(
            "n,nab->ab", weight, np.eye(3) - n[i][:, :, None] * n[i][:, None, :]
        )
    values, vectors = np.linalg.eigh(information - false)
    if values[-1] <= 0:
        return _unseen(r, "no direction was seen: neither segment turned", {"samples": float(len(e))})
    pairings = np.stack([along, along * np.repeat([1.0, -1.0], 3)])
    if np.abs(pairings @ vectors[:, 0]).max() > SAME_DIRECTION:  # the data's own idea of the hinge is the finer one
        along = vectors[:, 0]
    seen = (vectors * np.maximum(values, 1e-9 * values[-1])) @ vectors.T
    held = np.outer(along, along) * (scale / ALONG_STD) ** 2
    corrected = np.linalg.solve(seen + held, (information + held) @ r)  # what noise in the levers had shrunk
    information = (seen + held) / scale**2
    covariance = np.linalg.inv(information)
    covariance = (covariance + covariance.T) / 2
    across = np.eye(6) - np.outer(along, along)
    worst = float(np.sqrt(np.linalg.eigvalsh(across @ covariance @ across)[-1]))
    details = {"residual_std": scale, "samples": float(len(e)), "worst_std_across": worst}
    if np.linalg.norm(r.reshape(2, 3), axis=1).max() > REACH or worst > ALONG_STD or status == "not identifiable":
        return _unseen(
            r, f"one direction is seen to {worst:.2g} m only, or the motion does not show the hinge", details
        )
    value = corrected - along * (along @ corrected)
    return Estimate("joint_vector", "hinge-position", value.reshape(2, 3), covariance, status=status, details=details)


def _unseen(r: Array, why: str, details: dict[str, float]) -> Estimate:
    value = r.reshape(2, 3)
    return Estimate("joint_vector", "hinge-position", value, None, why, "not identifiable", details=details)
