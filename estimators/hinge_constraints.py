"""The two constraints that a hinge puts on a pair of IMUs, weighted and packed for many evaluations."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array

BLOCK = 2048  # samples; products this small stay in the cache and on one thread


@dataclass(frozen=True, slots=True)
class Constraints:
    """The two constraints of a hinge, ready to be evaluated at any pair of axes.

    ||w1 x j1|| - ||w2 x j2|| = 0 for every gyroscope sample (Olsson 2020, eq. 24) and
    j1 . a1 - j2 . a2 = 0 for every accelerometer sample (eq. 25). The second is linear in the
    axes, so its m samples enter as the triangular factor of [a1, -a2], at most six rows.
    """

    rates: Array  # (b, 2, 3, size) angular rates times their weights, in blocks, the last filled up with zeros
    forces: Array  # (2, k, 3) the factor's columns for j1 and for j2, weighted; k <= 6
    force_sums: Array  # (2, 3) sums of the weighted rows of [a1, -a2]
    gyro_count: int
    accel_count: int
    floor: float  # a cost that rounding alone can make


def weigh(
    gyro1: ArrayLike,
    gyro2: ArrayLike,
    accel1: ArrayLike,
    accel2: ArrayLike,
    w_gyro: ArrayLike = 1.0,
    w_accel: ArrayLike = 1.0,
) -> Constraints:
    """Weigh samples and prepare them: gyro (n, 3) in rad/s, accel (m, 3) in m/s^2, n and m independent.

    The weights are scalars or one per sample, (n,) and (m,), and may be zero but not negative.
    """
    rates = np.stack([np.asarray(gyro1, dtype=float).T, np.asarray(gyro2, dtype=float).T])
    rates = rates * np.asarray(w_gyro, dtype=float)
    rows = np.hstack([np.asarray(accel1, dtype=float), -np.asarray(accel2, dtype=float)])
    rows = rows * np.asarray(w_accel, dtype=float).reshape(-1, 1)
    factor = triangular(rows)
    scale = float(np.sum(rates * rates) + np.sum(factor * factor))
    return Constraints(
        rates=_blocks(rates),
        forces=np.ascontiguousarray(factor.reshape(-1, 2, 3).transpose(1, 0, 2)),
        force_sums=rows.sum(axis=0).reshape(2, 3),
        gyro_count=rates.shape[2],
        accel_count=rows.shape[0],
        floor=scale * (4 * np.finfo(float).eps) ** 2,
    )


def _blocks(rates: Array) -> Array:
    """Cut (2, 3, n) into (b, 2, 3, size); zeros fill the last block and change no sum."""
    count = max(1, -(-rates.shape[2] // BLOCK))
    size = -(-rates.shape[2] // count)
    padded = np.zeros((2, 3, count * size))
    padded[:, :, : rates.shape[2]] = rates
    return np.ascontiguousarray(padded.reshape(2, 3, count, size).transpose(2, 0, 1, 3))


def triangular(rows: Array, block: int = 512) -> Array:
    """Return R (k, 6), k <= 6, of the QR factorisation of rows (m, 6), by blocks that fit the cache.

    A Gram matrix would lose half the digits, and with them the comparison of costs near a zero.
    """
    while len(rows) > 2 * block:
        whole = len(rows) // block * block
        factors = np.asarray(np.linalg.qr(rows[:whole].reshape(-1, block, 6), mode="r"))
        rows = np.vstack([factors.reshape(-1, 6), rows[whole:]])
    return np.asarray(np.linalg.qr(rows, mode="r"))
