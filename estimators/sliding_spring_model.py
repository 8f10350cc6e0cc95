"""r(t) of a sensor on springs and what the samples say of it, with derivatives by all numbers of sliding_spring.py.

The inertial forces -K (d, d') of d itself, K = ([W']x + [W]x^2, 2 [W]x), are linear in d. So is a step of the
oscillators under a force that runs straight between samples, of states z = (d, d'),

    z_k+1 = E z_k + a u_k + b u_k+1,    u = force - K z.

Taken together, (I + b K_k+1) z_k+1 = (E - a K_k) z_k + a force_k + b force_k+1, a banded triangular system in all z:
one solution has d, another the derivatives of d by all numbers, each of which is d under a force of its own.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm, lapack

from imubench.arrays import Array
from imubench.estimators.sliding_rows import Rows, skew

TURN, DAMP, SOFT, LAG = slice(3, 6), 6, 7, 8
START, RATE, TILT = slice(9, 12), slice(12, 15), slice(15, 21)
COUNT = 21
EYE = np.eye(3)


def crossed(a: Array, b: Array) -> Array:
    """Return a x b of vectors (3, ..., n), by slices of (x, y, z, x, y): half the time of arrays of indices."""
    a, b = np.concatenate([a, a[:2]]), np.concatenate([b, b[:2]])
    out: Array = a[1:4] * b[2:5]
    out -= a[2:5] * b[1:4]
    return out


def inverted(M: Array) -> Array:
    """Return the inverses of M (n, 3, 3): the cross products of its columns over its determinant."""
    x, y, z = np.ascontiguousarray(M.transpose(2, 1, 0))
    rows = np.stack([crossed(y, z), crossed(z, x), crossed(x, y)])
    return (rows / np.sum(x * rows[0], axis=0)).transpose(2, 0, 1)


def stepped(turn: Array, damping: float, step: float) -> tuple[Array, Array, Array]:
    """Return E (2, 2, 3), a and b (2, 3) of x'' + 2 z m x' + m^2 x = u, m = `turn` (3,), over `step` s."""
    M = np.zeros((3, 4, 4))
    M[:, 0, 1], M[:, 2, 3] = 1.0, 1 / step
    M[:, 1, 0], M[:, 1, 1], M[:, 1, 2] = -(turn**2), -2 * damping * turn, 1.0
    X = expm(M * step)[:, :2].transpose(1, 2, 0)
    return X[:, :2], X[:, 2] - X[:, 3], X[:, 3]


class Oscillators:
    """Springs along three axes of a limb that turns, over even samples: states z = (d, d') under forces."""

    def __init__(self, turn: Array, damping: float, K: Array, step: float):
        """Take m (3,) in rad/s, the damping ratio, K (n, 3, 6) and the step in s."""
        E, a, b = stepped(turn, damping, step)
        n, later = len(K), K[1:]
        fed = inverted(EYE + later[:, :, :3] * b[0] + later[:, :, 3:] * b[1])  # I + K b, what u feeds back on itself
        part = np.concatenate([b[0, :, None] * fed, b[1, :, None] * fed], axis=1)
        stay = np.eye(6) - part @ later
        self._drive = np.concatenate([stay[:, :, :3] * a[0] + stay[:, :, 3:] * a[1], part], axis=2)
        free = np.empty((n - 1, 6, 6))  # E - a K
        for i in range(2):
            free[:, 3 * i : 3 * i + 3] = -a[i, :, None] * K[:-1]
            for j in range(2):
                free[:, range(3 * i, 3 * i + 3), range(3 * j, 3 * j + 3)] += E[i, j]
        system = np.zeros((n, 6, 12))  # of each number its diagonal and the eleven below it
        system[:, :, 0] = 1.0
        below = np.lib.stride_tricks.as_strided(system.reshape(-1)[6:], (n - 1, 6, 6), (72 * 8, 11 * 8, 8))
        below[:] = -np.swapaxes(stay @ free, 1, 2)  # of state k, on state k + 1
        self._system = system.reshape(6 * n, 12).T

    def under(self, force: Array, start: Array) -> Array:
        """Return z (n, 6, columns) under forces (n, 3, columns), from z (6, columns) at the first sample."""
        n, _, columns = force.shape
        force = np.ascontiguousarray(force)
        size = force.itemsize
        now_and_later = np.lib.stride_tricks.as_strided(
            force, (n - 1, 6, columns), (3 * columns * size, columns * size, size)
        )
        drive = np.empty((columns, n, 6))
        drive[:, 0] = start.T
        drive[:, 1:] = (self._drive @ now_and_later).transpose(2, 0, 1)
        z, _ = lapack.dtbtrs(self._system, drive.reshape(columns, -1).T, uplo="L", diag="U", overwrite_b=1)
        return np.ascontiguousarray(z.T.reshape(columns, n, 6).transpose(1, 2, 0))


@dataclass(frozen=True)
class Moved:
    """What the model makes of some numbers; z = (d, d')."""

    z: Array  # (n, 6) m, m/s
    z_by: Array  # (n, 6, 21)
    r: Array  # (n, 3) m
    turned: Array  # (n, 3, 3), how d and r0 go into r
    direct: Array  # (n, 3, 2), how softness and lag go into r besides through d
    predicted: Array  # (rows * 3,) of r, whitened
    by: Array  # (rows * 3, 21), its derivatives

    def r_by(self, part: slice = slice(None)) -> Array:
        """The derivatives of r, (n, 3, 21), at some of the samples."""
        found = self.turned[part] @ self.z_by[part, :3]
        found[:, :, SOFT : LAG + 1] += self.direct[part]
        found[:, :, :3] += self.turned[part]
        return np.asarray(found)


class SpringModel:
    """The equations of sliding_spring.py over the samples of `rows`. Vectors are (3, n) here."""

    def __init__(self, rows: Rows):
        self.rows = rows
        w = np.ascontiguousarray(rows.rate.T)
        w1, w2, w3, w4 = (np.ascontiguousarray(rows.motion(rows.since, k).T) for k in range(1, 5))
        self._w, self._w1, self._cross_w = w, w1, skew(rows.rate)
        self._up, self._tilts = np.ascontiguousarray(rows.steady.T), rows.gravity[1] * rows.tilts
        # (2, 3, n): what k and l make of theta, theta', W and W'
        self._theta, self._theta1, theta2 = (np.stack(pair) for pair in ((-w1, w2), (-w2, w3), (-w3, w4)))
        self._W = np.stack([crossed(t, w) - t1 for t, t1 in zip(self._theta, self._theta1, strict=True)])
        self._W1 = np.stack(
            [crossed(t1, w) + crossed(t, w1) - t2 for t, t1, t2 in zip(self._theta, self._theta1, theta2, strict=True)]
        )

    def _limb(self, p: Array) -> tuple[Array, ...]:
        """Return theta, the limb's W, W', and up as the sensor and as the limb has it, each (3, n)."""
        k, lag = p[SOFT], p[LAG]
        theta = k * self._theta[0] + lag * self._theta[1]
        W = self._w + k * self._W[0] + lag * self._W[1]
        W1 = self._w1 + k * self._W1[0] + lag * self._W1[1]
        up = self._up + (self._tilts @ p[TILT]).T
        return theta, W, W1, up, up + crossed(theta, up)

    def rest(self, p: Array) -> Array:
        """Return d (3,) in m at the first sample if the force there were at rest."""
        _, W, W1, _, up = (x[:, 0] for x in self._limb(p))
        r0 = p[:3]
        return np.asarray((up - crossed(W1, r0) - crossed(W, crossed(W, r0))) / np.exp(2 * p[TURN]))

    def moved(self, p: Array) -> Moved:
        """Return what the numbers p (21,) make.

        r0, the start and gravity act linearly; log m and log z as forces -2 m (m d + z d') and -2 m z d', all on the
        same oscillators; k and l by what they change of W, W' and up.
        """
        theta, W, W1, up, up_limb = self._limb(p)
        turn, damping = np.exp(p[TURN]), float(np.exp(p[DAMP]))
        cross_W = skew(W.T)
        K = np.concatenate([skew(W1.T) + cross_W @ cross_W, 2 * cross_W], axis=2)
        springs = Oscillators(turn, damping, K, self.rows.step)
        force = up_limb.T - K[:, :, :3] @ p[:3]
        z = springs.under(force[:, :, None], np.concatenate([p[START] + force[0] / turn**2, p[RATE]])[:, None])[..., 0]
        d, rate = z[:, :3], z[:, 3:]
        x, rates = np.ascontiguousarray((p[:3] + d).T), np.ascontiguousarray(rate.T)
        forces, starts = np.zeros((len(z), 3, COUNT)), np.zeros((6, COUNT))
        forces[..., :3] = -K[:, :, :3]
        forces[..., TILT] = self._tilts + skew(theta.T) @ self._tilts
        for i in range(3):
            forces[:, i, TURN.start + i] = -2 * turn[i] * (turn[i] * d[:, i] + damping * rate[:, i])
        forces[..., DAMP] = -2 * turn * damping * rate
        starts[:3] = forces[0] / turn[:, None] ** 2
        starts[:3, TURN] = np.diag(-2 * (d[0] - p[START]))
        starts[:3, DAMP] = 0.0
        for i, column in enumerate((SOFT, LAG)):
            forces[..., column] = (self._softly(i, W, up, x) - 2 * crossed(self._W[i], rates)).T
            starts[:3, column] = self._softly(i, W, up, p[:3, None], 1)[:, 0] / turn**2
        starts[:3, START] = starts[3:, RATE] = EYE
        return self._answer(theta, z, springs.under(forces, starts), x, rates, p)

    def _softly(self, i: int, W: Array, up: Array, x: Array, count: int | None = None) -> Array:
        """Return the force (3, n) by k (i = 0) or l (1) on a sensor that stays at x (3, n), at the first `count`."""
        theta, W_by, W1_by, W, up = (v[:, :count] for v in (self._theta[i], self._W[i], self._W1[i], W, up))
        x = np.broadcast_to(x, W.shape)
        return crossed(theta, up) - crossed(W1_by, x) - crossed(W, crossed(W_by, x)) - crossed(W_by, crossed(W, x))

    def _answer(self, theta: Array, z: Array, z_by: Array, x: Array, rates: Array, p: Array) -> Moved:
        """Take r = x - theta x x, x = r0 + d, and v = r' + w x r, and what these make of the rows."""
        n, w = len(z), self._w
        theta1 = p[SOFT] * self._theta1[0] + p[LAG] * self._theta1[1]
        keep = EYE - skew(theta.T)
        through = np.concatenate([self._cross_w @ keep - skew(theta1.T), keep], axis=2)  # v of (x, d')
        v = np.empty((n, 3, COUNT + 1))
        v[..., :COUNT] = through @ z_by
        v[..., :3] += through[:, :, :3]
        direct = np.empty((n, 3, 2))
        for i in range(2):
            r_by = -crossed(self._theta[i], x)
            direct[..., i] = r_by.T
            v[..., SOFT + i] += (crossed(w, r_by) - crossed(self._theta[i], rates) - crossed(self._theta1[i], x)).T
        r = x - crossed(theta, x)
        v[..., COUNT] = (rates - crossed(theta, rates) - crossed(theta1, x) + crossed(w, r)).T
        made = self.rows.summed(-v, self._cross_w @ v)
        return Moved(z, z_by, np.ascontiguousarray(r.T), keep, direct, made[:, COUNT], made[:, :COUNT])
