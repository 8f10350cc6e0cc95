"""r as a constant and a few oscillations of unknown frequency, as many as the evidence asks for.

    r(t) = r0 + sum_i A_i sin(2 pi f_i t) + B_i cos(2 pi f_i t)

Given the frequencies this is linear least squares with a prior. The frequencies are searched one after the other: the
one is added that raises the evidence, the probability of the samples with r0, A and B integrated out, the most, and
only if it does so by more than the choice among all frequencies is worth. So a constant r stays constant.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from imubench.arrays import Array
from imubench.estimators.sliding_waves import oscillations

R_STD = 0.5  # m, of r0 before any sample
LINE_STD = 0.03  # m, of each number of A and B before any sample: the most that soft tissue is said to move
FIXED = 9  # numbers besides the lines: r0, and six of gravity
ROUNDS = 6  # of the fixed point for the power of the noise


def evidence(G: Array, b: Array, yy: float, count: int) -> tuple[Array, Array, Array]:
    """Return log evidence (...), coefficients (..., p) and noise power (...) of y = A x + e, x of unit prior.

    G (..., p, p) = A^T A, b (..., p) = A^T y, yy = y^T y of `count` rows. e has the power that makes y most probable.
    """
    sizes, V = np.linalg.eigh(G)
    sizes, along = np.maximum(sizes, 0.0), np.einsum("...ij,...i->...j", V, b)
    squares, power = along * along, np.ones(G.shape[:-2])
    for _ in range(ROUNDS):
        p = power[..., None]
        inverse = 1 / (sizes + p)
        left = yy - np.add.reduce(squares * (sizes + 2 * p) * inverse * inverse, axis=-1)
        power = np.maximum(left / (count - np.add.reduce(sizes * inverse, axis=-1)), 1e-9)
    p = power[..., None]
    x = along / (sizes + p)
    left = (yy - np.add.reduce(along * x, axis=-1)) / power
    determinant = np.add.reduce(np.log1p(sizes / p), axis=-1)
    return -0.5 * (count * np.log(power) + left + determinant), np.einsum("...ij,...j->...i", V, x), power


def _spread(x: Array) -> Array:
    """Return (n, lines, 2) for each of three axes as columns (n, 3, lines * 6), lines and axes outermost."""
    n, lines, _ = x.shape
    return np.einsum("nls,ia->nilas", x, np.eye(3)).reshape(n, 3, lines * 6)


@dataclass(frozen=True)
class Lines:
    """A fitted r(t)."""

    felt: bool
    evidence: float  # nat
    noise: float  # residual power over that of the declared noise
    start: float  # s, what time counts from
    frequency: Array  # (lines,) Hz
    coefficients: Array  # (9 + 6 lines,): r0 in m, six errors of gravity in m/s^2, for each line and axis A and B in m
    covariance: Array  # of the coefficients and the frequencies

    @property
    def name(self) -> str:
        """What kind of r this is."""
        if self.frequency.size == 0:
            return "constant"
        return "felt" if self.felt else "unfelt"

    @cached_property
    def _sizes(self) -> Array:
        """The size of each sine and cosine along each axis, (lines, 3, 2) in m."""
        return self.coefficients[FIXED:].reshape(-1, 3, 2)

    @cached_property
    def _terms(self) -> tuple[list[float], list[tuple[float, list[list[float]]]]]:
        """r0, and of each oscillation 2 pi f and its sizes, as plain numbers: faster than arrays of three."""
        turns = (2 * np.pi * self.frequency).tolist()
        return self.coefficients[:3].tolist(), list(zip(turns, self._sizes.tolist(), strict=True))

    def at(self, time: float) -> Array:
        """Return r (3,) in m at one `time` in s."""
        (x, y, z), waves = self._terms
        for turn, ((xs, xc), (ys, yc), (zs, zc)) in waves:
            phase = turn * (time - self.start)
            s, c = math.sin(phase), math.cos(phase)
            x, y, z = x + xs * s + xc * c, y + ys * s + yc * c, z + zs * s + zc * c
        return np.array([x, y, z])

    def covariance_at(self, time: float) -> Array:
        """Return the covariance (3, 3) in m^2 of r at one `time` in s."""
        count, since = self.frequency.size, time - self.start
        phase = 2 * np.pi * since * self.frequency
        waves = np.array([np.sin(phase), np.cos(phase)]).T  # (lines, 2)
        J = np.zeros((3, self.covariance.shape[0]))
        J[0, 0] = J[1, 1] = J[2, 2] = 1.0
        of_sizes = J[:, FIXED : FIXED + 6 * count].reshape(3, count, 3, 2)
        for axis in range(3):
            of_sizes[axis, :, axis] = waves
        turned = self._sizes[:, :, 0] * waves[:, 1:] - self._sizes[:, :, 1] * waves[:, :1]
        J[:, FIXED + 6 * count :] = 2 * np.pi * since * turned.T
        return np.asarray(J @ self.covariance @ J.T)

    def r(self, time: Array) -> tuple[Array, Array]:
        """Return r (n, 3) in m and its covariance (n, 3, 3) at any `time` (n,) s."""
        J = design(time - self.start, self.frequency, self.coefficients)[0]
        r = J[..., : self.coefficients.size] @ self.coefficients
        return r, np.einsum("nip,pq,njq->nij", J, self.covariance, J, optimize=True)


def design(time: Array, frequency: Array, coefficients: Array) -> tuple[Array, Array]:
    """Return the derivatives (n, 3, p) of r and of r' by coefficients and frequencies, in this order."""
    values = oscillations(time, frequency)
    n, lines = time.size, frequency.size
    fixed = np.broadcast_to(np.eye(3, FIXED), (n, 3, FIXED)), np.zeros((n, 3, FIXED))
    sizes = coefficients[FIXED:].reshape(lines, 3, 2)
    by = [np.einsum("nls,las->nal", x, sizes) for x in values[2:]]
    r, rate = (np.concatenate([f, _spread(x), d], axis=2) for f, x, d in zip(fixed, values[:2], by, strict=True))
    return r, rate
