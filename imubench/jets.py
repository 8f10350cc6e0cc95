"""Arrays that carry their derivatives, so that a law is written once and its Jacobian is exact.

A `Jet` is a row of numbers per sample and, for each block of variables it depends on, the
derivative by that block. A `Turn` is a rotation per sample with the derivative of its
right-hand rotation vector: ``R(x + dx) = R(x) exp(D dx)``. Without blocks both are plain
arrays, and the same law then serves the simulator.

Samples lie next to each other in memory wherever arrays are made here (the first axis varies
fastest), so that a product of small matrices is a few long loops.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array

Key = tuple[str, int]
"""A block's name: (spline, order of the time derivative), or (parameter, CONSTANT)."""
CONSTANT = -1
Blocks = dict[Key, Array]

_followed: ContextVar[Collection[str] | None] = ContextVar("_followed", default=None)


@contextmanager
def derivatives_by(names: Collection[str]) -> Iterator[None]:
    """Take derivatives by these splines and parameters alone, all others being numbers; for the block it opens."""
    token = _followed.set(names)
    try:
        yield
    finally:
        _followed.reset(token)


def follows(name: str) -> bool:
    """Return whether derivatives by a spline or parameter are taken."""
    followed = _followed.get()
    return followed is None or name in followed


@dataclass(frozen=True)
class Jet:
    """Values (n, m) and their derivatives by each block of k variables, (n or 1, m, k)."""

    value: Array
    blocks: Blocks = field(default_factory=dict)

    __array_ufunc__ = None  # an array on the left hands over to the methods below

    def __add__(self, other: Jet | ArrayLike) -> Jet:
        b = jet(other)
        return Jet(self.value + b.value, _sum(self.blocks, b.blocks))

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet(-self.value, {key: -d for key, d in self.blocks.items()})

    def __sub__(self, other: Jet | ArrayLike) -> Jet:
        return self + (-jet(other))

    def __rsub__(self, other: ArrayLike) -> Jet:
        return jet(other) - self

    def __mul__(self, other: Jet | ArrayLike) -> Jet:
        b = jet(other)
        left = {key: d * b.value[:, :, None] for key, d in self.blocks.items()}
        right = {key: d * self.value[:, :, None] for key, d in b.blocks.items()}
        return Jet(self.value * b.value, _sum(left, right))

    __rmul__ = __mul__

    def __truediv__(self, other: Jet | ArrayLike) -> Jet:
        b = jet(other)
        return self * Jet(1 / b.value, {key: -d / b.value[:, :, None] ** 2 for key, d in b.blocks.items()})

    def __getitem__(self, columns: slice | list[int]) -> Jet:
        return Jet(self.value[:, columns], {key: d[:, columns] for key, d in self.blocks.items()})

    def through(self, value: Array, slope: Array) -> Jet:
        """Return a function of each number: its value (n, m) and its slope (n, m) there."""
        return Jet(value, {key: slope[:, :, None] * d for key, d in self.blocks.items()})

    def at(self, matrix: ArrayLike) -> Jet:
        """Return M x for a constant matrix M (l, m)."""
        m = np.asarray(matrix, dtype=float)
        return Jet(self.value @ m.T, {key: times(m[None], d) for key, d in self.blocks.items()})


@dataclass(frozen=True)
class Turn:
    """Rotations (n or 1, 3, 3), frame b -> frame a, and the blocks (n or 1, 3, k) of their rotation vector in b."""

    matrix: Array
    blocks: Blocks = field(default_factory=dict)

    def __matmul__(self, other: Turn) -> Turn:
        back = np.swapaxes(other.matrix, -1, -2)
        left = {key: times(back, d) for key, d in self.blocks.items()}
        return Turn(times(self.matrix, other.matrix), _sum(left, other.blocks))

    @property
    def inverse(self) -> Turn:
        """Return the rotation a -> b."""
        blocks = {key: -times(self.matrix, d) for key, d in self.blocks.items()}
        return Turn(np.swapaxes(self.matrix, -1, -2), blocks)

    def back(self, vector: Jet | ArrayLike) -> Jet:
        """Return R' v, a vector of frame a in axes of frame b."""
        v = jet(vector)
        matrix = np.swapaxes(self.matrix, -1, -2)
        value = times(matrix, v.value[:, :, None])[:, :, 0]
        moved = {key: crossed(value, d) for key, d in self.blocks.items()}
        return Jet(value, _sum(moved, {key: times(matrix, d) for key, d in v.blocks.items()}))

    def forth(self, vector: Jet | ArrayLike) -> Jet:
        """Return R v, a vector of frame b in axes of frame a."""
        return self.inverse.back(vector)


def jet(value: Jet | ArrayLike) -> Jet:
    """Return a `Jet`; a number or a row (m,) counts for every sample."""
    if isinstance(value, Jet):
        return value
    array = np.asarray(value, dtype=float)
    return Jet(array.reshape(1, -1) if array.ndim < 2 else array)


def variable(key: Key, value: Array) -> Jet:
    """Return a `Jet` of values (n, m) that are themselves the variables of block `key`."""
    value = np.atleast_2d(value)
    return Jet(value, {key: np.eye(value.shape[1])[None]} if follows(key[0]) else {})


def stack(*parts: Jet | ArrayLike) -> Jet:
    """Return the columns of all parts side by side."""
    jets = [jet(p) for p in parts]
    n = max(j.value.shape[0] for j in jets)
    values = [np.broadcast_to(j.value, (n, j.value.shape[1])) for j in jets]
    blocks: Blocks = {}
    for key in {key: None for j in jets for key in j.blocks}:
        have = [j.blocks.get(key) for j in jets]
        rows = max(d.shape[0] for d in have if d is not None)
        width = next(d.shape[2] for d in have if d is not None)
        full = [
            np.zeros((rows, j.value.shape[1], width)) if d is None else np.broadcast_to(d, (rows, *d.shape[1:]))
            for j, d in zip(jets, have, strict=True)
        ]
        blocks[key] = np.concatenate(full, axis=1)
    return Jet(np.concatenate(values, axis=1), blocks)


def cross(a: Jet | ArrayLike, b: Jet | ArrayLike) -> Jet:
    """Return a x b for vectors (n, 3)."""
    a, b = jet(a), jet(b)
    left = {key: crossed(-b.value, d) for key, d in a.blocks.items()}
    right = {key: crossed(a.value, d) for key, d in b.blocks.items()}
    return Jet(crossed(a.value, b.value[:, :, None])[:, :, 0], _sum(left, right))


def dot(a: Jet | ArrayLike, b: Jet | ArrayLike) -> Jet:
    """Return a . b (n, 1) for vectors (n, m)."""
    product = jet(a) * b
    total = product.value.sum(axis=1, keepdims=True)
    return Jet(total, {key: d.sum(axis=1, keepdims=True) for key, d in product.blocks.items()})


def rotation(vector: Jet | ArrayLike) -> Turn:
    """Return the `Turn` exp(v) of rotation vectors (n, 3) in rad, angle below pi."""
    v = jet(vector)
    angle = np.linalg.norm(v.value, axis=1)[:, None, None]
    k, eye = skew(v.value), np.eye(3)
    a = np.sinc(angle / np.pi)
    b = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    small = angle < 1e-2
    safe = np.where(small, 1.0, angle)
    c = np.where(small, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    square = times(k, k)
    right = eye - b * k + c * square  # the right Jacobian of the exponential map
    return Turn(eye + a * k + b * square, {key: times(right, d) for key, d in v.blocks.items()})


def about(axis: int, angle: Jet) -> Turn:
    """Return the `Turn` by angles (n, 1) about coordinate axis 0, 1 or 2."""
    unit = np.zeros(3)
    unit[axis] = 1.0
    return rotation(angle.at(unit[:, None]))


def skew(v: Array) -> Array:
    """Return the matrices (n, 3, 3) of v x, for vectors (n, 3)."""
    out = np.zeros((len(v), 3, 3), order="F")
    out[:, 0, 1], out[:, 0, 2] = -v[:, 2], v[:, 1]
    out[:, 1, 0], out[:, 1, 2] = v[:, 2], -v[:, 0]
    out[:, 2, 0], out[:, 2, 1] = -v[:, 1], v[:, 0]
    return out


def times(a: Array, b: Array) -> Array:
    """Return A B (n, l, k) of small matrices (n or 1, l, m) and (n or 1, m, k)."""
    if len(a) == len(b) == 1:
        return np.matmul(a, b)
    left, right = a.transpose(1, 2, 0)[:, :, None], b.transpose(1, 2, 0)
    out = left[:, 0] * right[0]
    for j in range(1, len(right)):
        out += left[:, j] * right[j]
    return np.asarray(out.transpose(2, 0, 1))


def crossed(v: Array, b: Array) -> Array:
    """Return v x each column (n, 3, k) of vectors v (n or 1, 3) and columns b (n or 1, 3, k)."""
    vector, columns = v.T, b.transpose(1, 2, 0)
    out = np.empty((3, columns.shape[1], max(len(v), len(b))))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(vector[j], columns[k], out=out[i])
        out[i] -= vector[k] * columns[j]
    return out.transpose(2, 0, 1)


def _sum(a: Mapping[Key, Array], b: Mapping[Key, Array]) -> Blocks:
    out = dict(a)
    for key, d in b.items():
        out[key] = out[key] + d if key in out else d
    return out
