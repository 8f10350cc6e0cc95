"""The filter of centre_ekf.py for many runs side by side: the same numbers, a fraction of the time.

Runs lie along the last axis of every array in here, so that each operation on one element of a small matrix is one
operation on a contiguous row of runs. Products use what is known: H is an identity beside a 3x9 block, and with
S = L L^T the update is P - W^T W with W = L^-1 H P, by elimination on [S | H P | innovation].
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.estimators.centre_ekf import A_, INITIAL, R_, V_, W_, Covariances, first_r

SKEWS = np.array(  # where [r]x and -[w']x have r (rows 0 to 2), w' (3 to 5), -r, -w' and 0 of `_signed`
    [[[12, 8, 1], [2, 12, 6], [7, 0, 12]], [[12, 5, 10], [11, 12, 3], [4, 9, 12]]]
)


@dataclass(frozen=True)
class Tracks:
    """What the filter says of every run at every sample from `first` on."""

    first: int  # the first sample with an answer
    r: Array  # (runs, n - first, 3) m
    covariance: Array  # (runs, n - first, 3, 3) m^2
    innovation_squared: Array  # (runs, n - first), normalised; NaN at the first, which only starts the filter


def track(
    gyro: ArrayLike,
    acceleration: ArrayLike,
    time: ArrayLike,
    states: int,
    covariances: Covariances,
    r0: ArrayLike | None = None,
    initial_samples: int = INITIAL,
) -> Tracks:
    """Filter runs of w in rad/s and a in m/s^2, each (runs, n, 3), at common stamps `time` (n,) s.

    `r0` (3,) or (runs, 3) in m; None: what MrVS makes of the first samples, and the answers start there. `states` as
    for `CentreFilter`. Raises `InputError` for unequal shapes, numbers that are not finite, or too few samples.
    """
    w, a, t = (np.asarray(x, dtype=float) for x in (gyro, acceleration, time))
    if w.ndim != 3 or w.shape != a.shape or w.shape[1:] != (t.size, 3):
        raise InputError(f"expected gyro and acceleration (runs, {t.size}, 3) alike, got {w.shape} and {a.shape}")
    if not (np.isfinite(w).all() and np.isfinite(a).all()) or not (np.diff(t) > 0).all():
        raise InputError("joint centre filter: expected finite samples and increasing time")
    if initial_samples < 3 or (r0 is None and t.size < initial_samples):
        raise InputError(f"expected 3 to {t.size} initial samples, got {initial_samples}")
    first = 0 if r0 is not None else initial_samples - 1
    start = first_r(w[:, : first + 1], a[:, : first + 1], t[: first + 1]) if r0 is None else np.asarray(r0, dtype=float)
    filters = _Runs(states, covariances, np.broadcast_to(start, (len(w), 3)).T, w[:, first].T)
    samples = np.ascontiguousarray(np.concatenate([w, a], axis=2).transpose(1, 2, 0))
    n = t.size - first
    r, P, nis = np.empty((n, 3, len(w))), np.empty((n, 3, 3, len(w))), np.full((n, len(w)), np.nan)
    r[0], P[0] = filters.x[R_], filters.P[R_, R_]
    for k, dt in enumerate(np.round(np.diff(t[first:]), 9).tolist(), start=1):
        nis[k] = filters.update(samples[first + k], dt)
        r[k], P[k] = filters.x[R_], filters.P[R_, R_]
    return Tracks(first, r.transpose(2, 0, 1), P.transpose(3, 0, 1, 2), nis.T)


class _Runs:
    """State x (states, runs) and P (states, states, runs) of all runs."""

    def __init__(self, states: int, covariances: Covariances, r0: Array, rate: Array):
        runs = r0.shape[1]
        self.states, self.covariances = states, covariances
        self.x = np.zeros((states, runs))
        self.x[R_], self.x[W_] = r0, rate
        self.P = np.repeat(covariances.initial(states)[..., None], runs, axis=2)
        self._pairs = [(W_, A_)] + [(R_, V_)] * (states == 12)
        self._R = np.diag(covariances.measurement())[:, None]
        self._J = np.zeros((3, 9, runs))
        self._augmented = np.zeros((6, 6 + states + 1, runs))  # [S | H P | innovation], then [. | W | y]
        self._diagonal_r, self._diagonal_w = np.einsum("iir->ir", self._J[:, R_]), np.einsum("iir->ir", self._J[:, W_])
        self._signed = np.zeros((13, runs))  # r and w', both negative, 0
        self._dt = -1.0

    def update(self, z: Array, dt: float) -> Array:
        """Take w and a of all runs, z (6, runs), `dt` s after the ones before; return innovations squared (runs,)."""
        self._predict(dt)
        G, J, P = self._augmented, self._J, self.P
        expected = self._linearise()
        HP = G[:, 6:-1]
        HP[:3] = P[W_]
        np.einsum("kjr,jir->kir", J, P[:9], out=HP[3:])
        S = G[:, :6]
        S[:, :3] = HP[:, W_]
        np.einsum("kjr,ljr->klr", HP[:, :9], J, out=S[:, 3:])
        np.einsum("iir->ir", S)[:] += self._R
        np.subtract(z[:3], self.x[W_], out=G[:3, -1])
        np.subtract(z[3:], expected, out=G[3:, -1])
        for k in range(6):
            row = G[k, k:]
            if k:
                row -= np.einsum("jr,jcr->cr", G[:k, k], G[:k, k:])
            row *= 1.0 / np.sqrt(row[0])
        self._subtract(HP)
        y = G[:, -1]
        self.x += np.einsum("kir,kr->ir", HP, y)
        return np.asarray(np.einsum("kr,kr->r", y, y))

    def _subtract(self, W: Array) -> None:
        """Take W^T W from P: the blocks on and above the diagonal, and those below by symmetry."""
        P = self.P
        for i in range(0, self.states, 3):
            rows, right, below = slice(i, i + 3), slice(i, None), slice(i + 3, None)
            P[rows, right] -= np.einsum("kir,kjr->ijr", W[:, rows], W[:, right])
            P[below, rows] = P[rows, below].transpose(1, 0, 2)

    def _predict(self, dt: float) -> None:
        if dt != self._dt:
            self._set_step(dt)
        x, P = self.x, self.P
        for level, rate in self._pairs:
            x[level] += dt * x[rate]
            P[level] += dt * P[rate]
        for level, rate in self._pairs:
            P[:, level] += dt * P[:, rate]
        for diagonal, q in self._noise:
            diagonal += q

    def _set_step(self, dt: float) -> None:
        """Keep what Q adds, and where: its 3x3 blocks are multiples of the identity, most of them zero."""
        Q = self.covariances.process(self.states, dt)
        starts = range(0, self.states, 3)
        self._noise = [
            (np.einsum("iir->ir", self.P[i : i + 3, j : j + 3]), Q[i, j]) for i in starts for j in starts if Q[i, j]
        ]
        self._dt = dt

    def _linearise(self) -> Array:
        """Fill da/d(r, w, w') as `linearise` of centre_ekf.py has it, and return a (3, runs)."""
        J, both = self._J, self._signed
        both[:3], both[3:6] = self.x[R_], self.x[A_]
        np.negative(both[:6], out=both[6:12])
        r, w = self.x[R_], self.x[W_]
        ww, wr = w[:, None] * w, w[:, None] * r
        skews = both.take(SKEWS, axis=0)
        J[:, A_] = skews[0]
        np.subtract(skews[1], ww, out=J[:, R_])
        np.subtract(2 * wr.transpose(1, 0, 2), wr, out=J[:, W_])
        self._diagonal_r += ww[0, 0] + ww[1, 1] + ww[2, 2]
        self._diagonal_w -= wr[0, 0] + wr[1, 1] + wr[2, 2]
        return np.asarray(np.einsum("kjr,jr->kr", J[:, R_], r))
