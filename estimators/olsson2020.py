"""The hinge axis in both sensors' axes by Olsson et al., Sensors 20 (2020) 3534, Algorithm 1."""

import math
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array
from imubench.estimate import Estimate, Pairing, Status
from imubench.estimators.extent import too_short
from imubench.estimators.hinge_constraints import Constraints, weigh
from imubench.estimators.hinge_fit import Solution, covariance, descend, scaled_information
from imubench.estimators.pairing import paired_axes
from imubench.estimators.spherical import coordinates, opposite
from imubench.paired import Paired, paired
from imubench.recording import Recording
from imubench.rotations import angle_between

W0 = 50.0  # section 7.3: w_gyro / w_accel
W_GYRO, W_ACCEL = math.sqrt(W0), 1.0 / math.sqrt(W0)  # eq. (70)
TOLERANCE = 1e-10  # of the cost, in one step; the paper gives no value for V_tol
STARTS = np.array([coordinates(pair) for pair in product(np.eye(3), repeat=2)])
"""(9, 4) rad: the 36 starts of section 7.2 but for the common sign, which changes nothing, and the
pairing, both of which Algorithm 1 tries."""
SCREENING = 4000  # samples that the starts are compared on; each minimum found then sees all
SAME = math.radians(2.0)  # minima closer than this are one
UNKNOWNS = 4  # two angles of either axis
NOISE = 0.6, 0.5  # J_s^T J_s per gyroscope, per accelerometer sample of nothing but white noise


def solve(
    gyro1: ArrayLike,
    gyro2: ArrayLike,
    accel1: ArrayLike,
    accel2: ArrayLike,
    start: ArrayLike,
    w_gyro: ArrayLike = W_GYRO,
    w_accel: ArrayLike = W_ACCEL,
    tolerance: float = TOLERANCE,
) -> tuple[Solution, Solution]:
    """Run Algorithm 1 from `start` (4,) in rad: the minimum of the better sign pairing, and of the other.

    gyro (n, 3) in rad/s and accel (m, 3) in m/s^2 may be different sets of samples; the weights are
    scalars or one per sample.
    """
    return algorithm1(weigh(gyro1, gyro2, accel1, accel2, w_gyro, w_accel), start, tolerance)


def algorithm1(c: Constraints, start: ArrayLike, tolerance: float = TOLERANCE) -> tuple[Solution, Solution]:
    """Run Algorithm 1 on samples that are weighed already; returns as `solve`."""
    first = descend(c, start, tolerance)
    second = descend(c, opposite(first.x), tolerance)
    return (first, second) if first.cost <= second.cost else (second, first)


def estimate(recording: Recording) -> Estimate:
    """Estimate the hinge axis (2, 3), from all samples and no start.

    The pairing of the signs is that of the lower cost, where the accelerometers tell it, else that of the declared
    mounts, if any (`pairing`). The common sign points along +y of the segments as the declared mounts have them.
    `not identifiable` where the IMUs share too few samples. Raises `InputError` with fewer than two IMUs.
    """
    samples = paired(recording)
    step = -(-samples.time.size // SCREENING)
    minima = [algorithm1(_weigh(samples, step), start)[0] for start in STARTS]
    whole = _weigh(samples)
    finals = [algorithm1(whole, minimum.x) for minimum in distinct(minima)]
    best, other = min(finals, key=lambda pair: pair[0].cost)
    apart = np.array([deviation(minimum.axes, best.axes) for minimum in minima])
    details = {
        "cost": best.cost,
        "cost_other_pairing": other.cost,
        "iterations": float(sum(s.iterations for pair in finals for s in pair)),
        "samples": float(samples.time.size),
        "starts": float(len(STARTS)),
        "starts_agreeing": float(np.sum(apart < SAME)),
        "spread": float(apart.max()),  # rad, of the minima that the starts led to from the best
        "gyro_residual_std": best.gyro_std / W_GYRO,  # rad/s
        "accel_residual_std": best.accel_std / W_ACCEL,  # m/s^2
    }
    axes, pairing = paired_axes(recording, best.axes, samples.accel1, samples.accel2)
    return answer("olsson2020", whole, best, axes, details, pairing, too_short(samples.time, UNKNOWNS))


def _weigh(samples: Paired, step: int = 1) -> Constraints:
    every = slice(None, None, step)
    return weigh(
        samples.gyro1[every], samples.gyro2[every], samples.accel1[every], samples.accel2[every], W_GYRO, W_ACCEL
    )


def distinct(minima: list[Solution]) -> list[Solution]:
    """Return minima that differ in their axes, the lowest first."""
    kept: list[Solution] = []
    for minimum in sorted(minima, key=lambda m: m.cost):
        if all(deviation(minimum.axes, other.axes) > SAME for other in kept):
            kept.append(minimum)
    return kept


def deviation(axes: Array, others: Array) -> float:
    """Return the larger angle in rad between two pairs of axes (2, 3), a common sign aside."""
    return float(min(angle_between(axes, others).max(), angle_between(axes, -others).max()))


def answer(
    name: str,
    c: Constraints,
    s: Solution,
    axes: Array,
    details: dict[str, float],
    pairing: Pairing = "unknown",
    short: str = "",
) -> Estimate:
    """Return the estimate of `axes` (2, 3), those of `s` up to their signs, with its covariance (6, 6).

    `pairing` says what the signs are worth, `short` why the samples are too few, if they are.
    """
    status: Status = "converged" if s.converged else "not converged"
    tangent = covariance(c, s) if not short and identifiable(c, s) else None
    if tangent is None:
        reason = short or (
            "there is a direction in which the axes can move with no more change of the residuals than they scatter"
        )
        return Estimate("joint_axis", name, axes, None, reason, "not identifiable", details=details, pairing="unknown")
    flips = np.sign(np.sum(axes * s.axes, axis=1))
    to_axes = np.zeros((6, 4))
    for i in range(2):
        to_axes[3 * i : 3 * i + 3, 2 * i : 2 * i + 2] = flips[i] * s.tangents[i].T
    spread = to_axes @ tangent @ to_axes.T
    return Estimate("joint_axis", name, axes, spread, status=status, details=details, pairing=pairing)


def identifiable(c: Constraints, s: Solution) -> bool:
    """Tell whether moving either axis in any direction changes the residuals by more than they scatter.

    White noise alone makes J_s^T J_s of eq. (57) regular, see NOISE; ten times that is asked for. And
    gyroscope samples count only if the joint moved, that is if |w1| - |w2|, eq. (42), is more than
    residual: in stiff motion they fit any axis (section 4.2), and noise picks one of them.
    """
    information = s.gyro_information + s.accel_information
    scaled = scaled_information(s)
    if not _joint_moved(c, s):
        information, scaled = s.accel_information, s.accel_information / max(s.accel_std, 1e-100) ** 2
    plain = np.linalg.eigvalsh(information)
    if plain[0] <= 1e-9 * plain[-1]:
        return False
    noise = NOISE[0] * c.gyro_count + NOISE[1] * c.accel_count
    return bool(np.linalg.eigvalsh(scaled)[0] > 10.0 * noise)


def _joint_moved(c: Constraints, s: Solution) -> bool:
    norms = np.sqrt(np.sum(c.rates**2, axis=2))
    difference = float(np.sum((norms[:, 0] - norms[:, 1]) ** 2))
    rounding = 1e-18 * float(np.sum(norms**2))
    return difference > max(25.0 * s.gyro_std**2 * c.gyro_count, rounding)
