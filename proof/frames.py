"""Moving frames on the fine grid of time, and how one frame rides on another.

A frame c rides on a frame b at the place d (axes of b), turned by Q (c -> b), with u the angular rate of c relative
to b in axes of c (dQ/dt = Q [u]x). Then, w being a frame's angular rate in its own axes and f = R^T (a - g) the
specific force at its origin in its own axes,

    p_c  = p_b + R_b d                         R_c = R_b Q
    w_c  = Q^T w_b + u                         w_c' = Q^T w_b' + u' - u x (Q^T w_b)
    f_c  = Q^T (f_b + d'' + 2 w_b x d' + w_b' x d + w_b x (w_b x d))

Gravity enters once, in the first frame of a chain. All this is exact, there is no small-angle step.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from imubench.proof.rotation import Array, about, apply, apply_back

STEP = 1e-3  # s, the fine grid
LEAD = 2.0  # s of motion before the first sample, in which mounts and filters forget their start
TAIL = 0.6  # s after the last


@dataclass(frozen=True)
class Track:
    """One moving frame on the fine grid."""

    p: Array  # (n, 3) m, origin in the world
    R: Array  # (n, 3, 3) frame -> world
    w: Array  # (n, 3) rad/s, own axes
    dw: Array  # (n, 3) rad/s^2, own axes
    f: Array  # (n, 3) m/s^2, specific force at the origin, own axes

    def placed(self, d: ArrayLike, d1: ArrayLike | None = None, d2: ArrayLike | None = None) -> "Track":
        """Return the frame at d (n, 3) or (3,) m, not turned; d1, d2: the derivatives of d (axes of this frame)."""
        d = np.broadcast_to(np.asarray(d, dtype=float), self.w.shape)
        f = self.f + np.cross(self.dw, d) + np.cross(self.w, np.cross(self.w, d))
        if d1 is not None:
            f = f + 2 * np.cross(self.w, np.asarray(d1, dtype=float))
        if d2 is not None:
            f = f + np.asarray(d2, dtype=float)
        return replace(self, p=self.p + apply(self.R, d), f=f)

    def turned(self, Q: Array, u: Array | None = None, du: Array | None = None) -> "Track":
        """Return the frame turned by Q (n, 3, 3) or (3, 3); u, du (n, 3): its relative rate, in its own axes."""
        w, dw = apply_back(Q, self.w), apply_back(Q, self.dw)
        if u is not None and du is not None:
            dw = dw + du - np.cross(u, w)
            w = w + u
        return Track(self.p, self.R @ Q, w, dw, apply_back(Q, self.f))

    def rotated(self, axis: int, angle: Array, rate: Array, accel: Array) -> "Track":
        """Return the frame turned about one of its axes by an angle (n,) with its two derivatives."""
        e = np.eye(3)[axis]
        return self.turned(about(axis, angle), rate[:, None] * e, accel[:, None] * e)


def grid(seconds: float) -> Array:
    """Return the fine grid (n,) in s for a recording that starts at 0 and lasts `seconds`."""
    return STEP * np.arange(-round(LEAD / STEP), round((seconds + TAIL) / STEP) + 1, dtype=float)


def in_world(p: Array, acceleration: Array, gravity: float) -> Track:
    """Return an unturned frame that moves along p (n, 3) with the acceleration (n, 3) in the world."""
    n = len(p)
    zero = np.zeros((n, 3))
    return Track(p, np.broadcast_to(np.eye(3), (n, 3, 3)), zero, zero, acceleration + np.array([0.0, 0.0, gravity]))


def read_at(time: ArrayLike, values: Array) -> Array:
    """Return grid values (n, ...) at times (m,) s, by the polynomial through the six nearest grid points.

    Grid point `LEAD / STEP` is time 0. At 20 Hz the error is under 1e-7 of the signal.
    """
    place = (np.asarray(time, dtype=float) + LEAD) / STEP
    first = np.clip(np.floor(place).astype(int) - 2, 0, len(values) - 6)
    x = place - first
    points = range(6)
    weights = np.stack(
        [np.prod([(x - k) / (j - k) for k in points if k != j], axis=0) for j in points], axis=-1
    )  # Lagrange
    nearest = values[first[:, None] + np.arange(6)]
    return np.asarray(np.einsum("mj,mj...->m...", weights, nearest))
