"""Quaternion algebra on arrays; quaternions are w, x, y, z along the last axis."""

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array


def _parts(q: ArrayLike) -> tuple[Array, Array, Array, Array]:
    q = np.asarray(q, dtype=float)
    return q[..., 0], q[..., 1], q[..., 2], q[..., 3]


def conjugate(q: ArrayLike) -> Array:
    """Return the inverse of unit quaternions (..., 4)."""
    return np.asarray(q, dtype=float) * np.array([1.0, -1.0, -1.0, -1.0])


def multiply(p: ArrayLike, q: ArrayLike) -> Array:
    """Return the Hamilton product p q of quaternions (..., 4): first q turns, then p."""
    pw, px, py, pz = _parts(p)
    qw, qx, qy, qz = _parts(q)
    return np.stack(
        [
            pw * qw - px * qx - py * qy - pz * qz,
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
        ],
        axis=-1,
    )


def to_matrix(q: ArrayLike) -> Array:
    """Return rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    q = np.asarray(q, dtype=float)
    w, x, y, z = _parts(q)
    matrix = np.empty((*q.shape[:-1], 3, 3))
    matrix[..., 0, 0] = 1 - 2 * (y * y + z * z)
    matrix[..., 0, 1] = 2 * (x * y - w * z)
    matrix[..., 0, 2] = 2 * (x * z + w * y)
    matrix[..., 1, 0] = 2 * (x * y + w * z)
    matrix[..., 1, 1] = 1 - 2 * (x * x + z * z)
    matrix[..., 1, 2] = 2 * (y * z - w * x)
    matrix[..., 2, 0] = 2 * (x * z - w * y)
    matrix[..., 2, 1] = 2 * (y * z + w * x)
    matrix[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return matrix


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Turn vectors v (..., 3) by quaternions q (..., 4): sensor -> world for q_ws."""
    return np.einsum("...ij,...j->...i", to_matrix(q), np.asarray(v, dtype=float))


def rotate_back(q: ArrayLike, v: ArrayLike) -> Array:
    """Turn vectors v (..., 3) by the inverse of quaternions q (..., 4)."""
    return np.einsum("...ji,...j->...i", to_matrix(q), np.asarray(v, dtype=float))


def exp(rotation: ArrayLike) -> Array:
    """Return the quaternions (..., 4) of rotation vectors (..., 3) in rad."""
    half = np.asarray(rotation, dtype=float) / 2
    angle = np.linalg.norm(half, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle), half * np.sinc(angle / np.pi)], axis=-1)


def log(q: ArrayLike) -> Array:
    """Return the rotation vectors (..., 3) of unit quaternions (..., 4), angle at most pi."""
    q = np.asarray(q, dtype=float)
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(sine, q[..., :1])
    scale = np.where(sine > 1e-12, 2 * half / np.where(sine > 1e-12, sine, 1.0), 2.0)
    return q[..., 1:] * scale


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Return quaternions (..., 4) that turn by `angle` (...) rad about the unit vector `axis` (3,)."""
    return exp(np.asarray(angle, dtype=float)[..., None] * np.asarray(axis, dtype=float))


def from_matrix(matrix: ArrayLike) -> Array:
    """Return the unit quaternions (..., 4), w >= 0, of rotation matrices (..., 3, 3)."""
    from scipy.spatial.transform import Rotation

    m = np.asarray(matrix, dtype=float)
    q = Rotation.from_matrix(m.reshape(-1, 3, 3)).as_quat(canonical=True, scalar_first=True)
    return q.reshape(*m.shape[:-2], 4)


def continuous(q: ArrayLike) -> Array:
    """Return quaternions (n, 4) with signs by which each lies on the side of the one before; the first as it is."""
    q = np.asarray(q, dtype=float)
    flips = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)
    return np.asarray(q * np.cumprod(np.concatenate([[1.0], flips]))[:, None])


def random(rng: np.random.Generator, count: int | None = None) -> Array:
    """Return quaternions (4,) or (count, 4), uniform over the rotations."""
    q = rng.normal(size=(4,) if count is None else (count, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def angle_between(u: ArrayLike, v: ArrayLike) -> Array:
    """Return the angle (...) in rad between vectors (..., 3), accurate near 0 and pi."""
    u, v = np.asarray(u, dtype=float), np.asarray(v, dtype=float)
    return np.arctan2(np.linalg.norm(np.cross(u, v), axis=-1), np.sum(u * v, axis=-1))
