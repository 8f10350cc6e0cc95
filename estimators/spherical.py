"""Pairs of unit vectors in spherical coordinates: Olsson 2020, eq. (20), (21) and (41).

That chart loses rank at the poles. So a step is taken in axes turned along with the estimate,
where the estimate sits at theta = phi = 0: Gauss-Newton does not depend on the scale of phi, the
step is the paper's, and no pole is ever near.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from imubench.arrays import Array


def coordinates(axes: ArrayLike) -> Array:
    """Return theta and phi (..., 2 m) in rad of unit vectors (..., m, 3), the inverse of eq. (21)."""
    a = np.asarray(axes, dtype=float)
    theta = np.arctan2(a[..., 2], np.hypot(a[..., 0], a[..., 1]))
    pairs = np.stack([theta, np.arctan2(a[..., 1], a[..., 0])], axis=-1)
    return pairs.reshape(*a.shape[:-2], -1)


def chart(x: ArrayLike) -> Array:
    """Return (2, 3, 3): for each sensor the rows j, dj/dtheta and dj/dphi / cos theta at x (4,).

    Olsson 2020, eq. (21) and (41), the latter with the column of phi at unit length.
    """
    rows = []
    theta1, phi1, theta2, phi2 = np.asarray(x, dtype=float).tolist()
    for theta, phi in ((theta1, phi1), (theta2, phi2)):
        ct, st, cp, sp = math.cos(theta), math.sin(theta), math.cos(phi), math.sin(phi)
        rows.append(((ct * cp, ct * sp, st), (-st * cp, -st * sp, ct), (-sp, cp, 0.0)))
    return np.array(rows)


def turn(frames: Array, step: Array) -> Array:
    """Move frames (2, 3, 3) by a step (4,) in the chart whose x, y, z axes are their j, dj/dphi, dj/dtheta."""
    return np.asarray(chart(step) @ frames[:, (0, 2, 1)])


def opposite(x: ArrayLike) -> Array:
    """Return the coordinates (4,) of (j1, -j2), the other sign pairing (Olsson 2020, eq. 28)."""
    theta1, phi1, theta2, phi2 = np.asarray(x, dtype=float)
    return np.array([theta1, phi1, -theta2, phi2 + math.pi])
