"""r as a constant and a few oscillations of unknown frequency, as many as the evidence asks for.

    r(t) = r0 + sum_i A_i sin(2 pi f_i t) + B_i cos(2 pi f_i t)

Given the frequencies this is linear least squares with a prior. The frequencies are searched one after the other: the
one is added that raises the evidence, the probability of the samples with r0, A and B integrated out, the most, and
only if it does so by more than the choice among all frequencies is worth. So a constant r stays constant.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from imubench.arrays import Array
from imubench.estimators.sliding_rows import Rows

R_STD = 0.5  # m, of r0 before any sample
LINE_STD = 0.03  # m, of each number of A and B before any sample: the most that soft tissue is said to move
LOWEST, HIGHEST = 0.1, 6.0  # Hz
LINES = 4  # at most
FIXED = 9  # numbers besides the lines: r0, and six of gravity
ROUNDS = 6  # of the fixed point for the power of the noise


def evidence(G: Array, b: Array, yy: float, count: int) -> tuple[Array, Array, Array]:
    """Return log evidence (...), coefficients (..., p) and noise power (...) of y = A x + e, x of unit prior.

    G (..., p, p) = A^T A, b (..., p) = A^T y, yy = y^T y of `count` rows. e has the power that makes y most probable.
    """
    sizes, V = np.linalg.eigh(G)
    sizes, along = np.maximum(sizes, 0.0), np.einsum("...ij,...i->...j", V, b)
    power = np.ones(G.shape[:-2])
    for _ in range(ROUNDS):
        weight = sizes + power[..., None]
        x = along / weight
        left = yy - 2 * np.sum(along * x, axis=-1) + np.sum(sizes * x * x, axis=-1)
        power = np.maximum(left / (count - np.sum(sizes / weight, axis=-1)), 1e-9)
    x = along / (sizes + power[..., None])
    squares = (yy - np.sum(along * x, axis=-1)) / power
    determinant = np.sum(np.log1p(sizes / power[..., None]), axis=-1)
    return -0.5 * (count * np.log(power) + squares + determinant), np.einsum("...ij,...j->...i", V, x), power


def oscillations(time: Array, frequency: Array) -> tuple[Array, Array, Array, Array]:
    """Return sin, cos (n, lines, 2), their rates, and the derivatives of both by the frequency in Hz."""
    turn, phase = 2 * np.pi * frequency, 2 * np.pi * np.multiply.outer(time, frequency)
    sine, cosine = np.sin(phase), np.cos(phase)
    by = 2 * np.pi * time[:, None]
    value, rate = np.stack([sine, cosine], axis=-1), np.stack([turn * cosine, -turn * sine], axis=-1)
    value_by = np.stack([by * cosine, -by * sine], axis=-1)
    rate_by = np.stack([2 * np.pi * cosine - turn * by * sine, -2 * np.pi * sine - turn * by * cosine], axis=-1)
    return value, rate, value_by, rate_by


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


class _Search:
    """The whitened rows of one record with the frequencies found so far."""

    def __init__(self, rows: Rows, felt: bool):
        self.rows, self.felt, self.time = rows, felt, rows.time - rows.time[0]
        self.y = rows.measured
        self.frequency = np.zeros(0)
        self.length = float(self.time[-1])
        self.choice = float(np.log(2 * self.length * (HIGHEST - LOWEST)))  # nat: one of so many frequencies
        n = self.time.size
        fixed = np.broadcast_to(np.eye(3), (n, 3, 3))
        rigid = R_STD * rows.predicted(fixed, np.zeros((n, 3, 3)), felt)
        self.A = np.hstack([rigid, rows.gravity[1] * rows.tilted])
        self.best = self._weigh(self.A)

    def _weigh(self, A: Array) -> float:
        return float(evidence(A.T @ A, A.T @ self.y, float(self.y @ self.y), self.y.size)[0])

    def _columns(self, frequency: Array) -> Array:
        value, rate, _, _ = oscillations(self.time, frequency)
        return LINE_STD * self.rows.predicted(_spread(value), _spread(rate), self.felt)

    def scan(self) -> tuple[Array, Array, Array]:
        """Return a grid of frequencies with their columns and Gram matrices, once for a record."""
        spacing = 0.5 / self.length
        grid = np.arange(max(LOWEST, spacing), min(HIGHEST, 0.4 / self.rows.step), spacing)
        C = self._columns(grid).reshape(self.y.size, grid.size, 6).transpose(1, 2, 0)
        return grid, C, C @ C.transpose(0, 2, 1)

    def add(self, grid: Array, C: Array, CC: Array) -> bool:
        """Add the frequency that raises the evidence most; tell whether it was worth it."""
        p = self.A.shape[1]
        G = np.empty((grid.size, p + 6, p + 6))
        G[:, :p, :p], G[:, p:, p:] = self.A.T @ self.A, CC
        G[:, p:, :p] = C @ self.A
        G[:, :p, p:] = G[:, p:, :p].transpose(0, 2, 1)
        b = np.concatenate([np.broadcast_to(self.A.T @ self.y, (grid.size, p)), C @ self.y], axis=1)
        at = int(np.argmax(evidence(G, b, float(self.y @ self.y), self.y.size)[0]))
        frequency, found = self._refined(self.A, grid[at], grid[1] - grid[0])
        found -= self.choice * (self.frequency.size + 1)
        if not found > self.best:
            return False
        self.best = found
        self.frequency = np.append(self.frequency, frequency)
        self.A = np.hstack([self.A, self._columns(self.frequency[-1:])])
        if self.frequency.size > 1:
            self._polish()
        return True

    def _refined(self, others: Array, frequency: float, width: float) -> tuple[float, float]:
        """Return the best frequency near one, and its evidence, beside the columns of others."""
        found = minimize_scalar(
            lambda f: -self._weigh(np.hstack([others, self._columns(np.array([f]))])),
            bounds=(max(frequency - width, 0.5 * LOWEST), frequency + width),
            method="bounded",
            options={"xatol": 1e-3 * width},
        )
        return float(found.x), -float(found.fun)

    def _polish(self) -> None:
        """Move each frequency once more beside the others: a new one may explain what an old one was bent to."""
        width = 0.25 / self.length
        for i in range(self.frequency.size):
            own = slice(FIXED + 6 * i, FIXED + 6 + 6 * i)
            self.frequency[i], _ = self._refined(np.delete(self.A, own, axis=1), self.frequency[i], width)
            self.A[:, own] = self._columns(self.frequency[i : i + 1])
        self.best = self._weigh(self.A) - self.choice * self.frequency.size

    def answer(self) -> Lines:
        """Return the fit, with a covariance that counts the frequencies among what is unknown."""
        gravity = np.full(6, self.rows.gravity[1])
        prior = np.concatenate([np.full(3, R_STD), gravity, np.full(6 * self.frequency.size, LINE_STD)])
        A, count = self.A, self.frequency.size
        weight, x, power = evidence(A.T @ A, A.T @ self.y, float(self.y @ self.y), self.y.size)
        coefficients = prior * x
        r, rate = design(self.time, self.frequency, coefficients)
        J = np.hstack([A / prior, self.rows.predicted(r[..., prior.size :], rate[..., prior.size :], self.felt)])
        loose = np.full(count, 1 / self.length)  # Hz: the search has put each on its peak
        information = J.T @ J / power + np.diag(1 / np.concatenate([prior, loose]) ** 2)
        covariance = np.linalg.inv(information)
        return Lines(
            self.felt,
            float(weight) - self.choice * count,
            float(power),
            float(self.rows.time[0]),
            self.frequency,
            coefficients,
            covariance,
        )


def fit(rows: Rows, felt: bool, lines: int = LINES) -> Lines:
    """Return r0 and as many oscillations, `lines` at most, as the evidence asks for."""
    search = _Search(rows, felt)
    scanned = search.scan() if lines else None
    while scanned and search.frequency.size < lines and search.add(*scanned):
        pass
    return search.answer()
