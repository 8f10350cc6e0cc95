"""Rotations as matrices, rotation vectors and quaternions w, x, y, z, on arrays."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Parameters = dict[str, Any]


def skew(v: ArrayLike) -> Array:
    """Return [v]x (..., 3, 3) with [v]x a = v x a."""
    v = np.asarray(v, dtype=float)
    S = np.zeros((*v.shape, 3))
    S[..., 2, 1], S[..., 0, 2], S[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    return S - np.swapaxes(S, -1, -2)


def exp(vector: ArrayLike) -> Array:
    """Return rotation matrices (..., 3, 3) of rotation vectors (..., 3) in rad, by Rodrigues' formula."""
    S = skew(vector)
    angle = np.linalg.norm(np.asarray(vector, dtype=float), axis=-1)[..., None, None]
    half = np.sinc(angle / (2 * np.pi))  # sin(angle/2) / (angle/2)
    return np.eye(3) + np.sinc(angle / np.pi) * S + 0.5 * half**2 * (S @ S)


def about(axis: int, angle: ArrayLike) -> Array:
    """Return rotation matrices (..., 3, 3) about coordinate axis 0, 1 or 2 by `angle` (...)."""
    angle = np.asarray(angle, dtype=float)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.zeros((*angle.shape, 3, 3))
    R[..., axis, axis] = 1.0
    R[..., i, i] = R[..., j, j] = np.cos(angle)
    R[..., j, i] = np.sin(angle)
    R[..., i, j] = -R[..., j, i]
    return R


def to_quaternion(R: ArrayLike) -> Array:
    """Return unit quaternions (..., 4) of rotation matrices (..., 3, 3), the largest component found first."""
    R = np.asarray(R, dtype=float)
    d = np.stack([R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]], axis=-1)
    trace = d.sum(axis=-1, keepdims=True)
    # K's rows are 4 q_i q: every one is a multiple of q, the longest is the best conditioned
    K = np.empty((*R.shape[:-2], 4, 4))
    K[..., 0, 0] = 1 + trace[..., 0]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        K[..., 0, i + 1] = K[..., i + 1, 0] = R[..., k, j] - R[..., j, k]
        K[..., i + 1, i + 1] = 1 + 2 * d[..., i] - trace[..., 0]
        K[..., i + 1, j + 1] = K[..., j + 1, i + 1] = R[..., i, j] + R[..., j, i]
    best = np.argmax(np.diagonal(K, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(K, best[..., None, None], axis=-2)[..., 0, :]
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def from_quaternion(q: ArrayLike) -> Array:
    """Return rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    q = np.asarray(q, dtype=float)
    S = skew(q[..., 1:])
    return np.eye(3) + 2 * q[..., :1, None] * S + 2 * S @ S


def log(R: ArrayLike) -> Array:
    """Return rotation vectors (..., 3) of rotation matrices (..., 3, 3), angle in [0, pi]."""
    q = to_quaternion(R)
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, q[..., :1])
    return q[..., 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 2.0)


def euler_xyz(R: Array) -> Array:
    """Return angles (3,) a, b, c with R = Rx(a) Ry(b) Rz(c)."""
    return np.array([np.arctan2(-R[1, 2], R[2, 2]), np.arcsin(np.clip(R[0, 2], -1, 1)), np.arctan2(-R[0, 1], R[0, 0])])


def random_rotation(rng: np.random.Generator) -> Array:
    """Return a rotation matrix (3, 3), uniform over all."""
    q = rng.standard_normal(4)
    return from_quaternion(q / np.linalg.norm(q))


def apply(R: Array, v: Array) -> Array:
    """Return R v for matrices (..., 3, 3) and vectors (..., 3)."""
    return np.einsum("...ij,...j->...i", R, v)


def apply_back(R: Array, v: Array) -> Array:
    """Return R^T v."""
    return np.einsum("...ji,...j->...i", R, v)
