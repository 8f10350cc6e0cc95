"""Jolts: what the velocities of sprung mounts do when the segments' rates change at once.

No spring or damper notices a change at once; inertia alone does. In segment axes, with V and w the changes of the
segment's velocity at its origin and of its rate, r the pivot, c the centre of mass from there and k the radius of
gyration about it, the same about every axis:

    translation alone        x' -= V + w x (r + c)                    (the segment takes the sensor's turning along)
    rotation alone           omega -= w + c x (V + w x r) / k^2       (the pivot takes its place along)
    both                     x' -= V + w x r,   omega -= w            (the sensor flies free)

omega, the sensor's rate relative to the segment, is that of three joints in a row about x, y and z.
"""

from typing import NamedTuple

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.sim.rigs import Mount
from imubench.sim.threes import cross, matrix, product, rows, turn_back
from imubench.truth import SegmentTruth


def jolted(mount: Mount, jump: SegmentTruth, positions: Array, velocities: Array) -> Array:
    """Return the velocities (n, joints) of a mount after the motion of its segment changed by the rates of `jump`.

    `positions` and `velocities` (n, joints) are those of its slides, if it has them, and then of its hinges.
    """
    x, after = rows(positions), rows(velocities).copy()
    w, com = rows(jump.rate), mount.com[:, None]
    V = turn_back(matrix(rows(jump.quaternion)), rows(jump.velocity))
    pivot = (mount.position - rotations.rotate(mount.quaternion, mount.lever))[:, None]
    if mount.translation is not None:
        pivot = pivot + x[:3]
        if mount.rotation is None:
            after[:3] -= V + cross(w, pivot + rotations.rotate(mount.quaternion, mount.com)[:, None])
            return after.T
        after[:3] -= V + cross(w, pivot)
    turned = turned_by(x[-3:])
    R = matrix(product(mount.quaternion[:, None], turned.quaternion))
    change = turn_back(R, w)  # sensor axes from here on
    if mount.translation is None:
        change += cross(com, turn_back(R, V + cross(w, pivot))) / mount.gyration**2
    after[-3:] -= joint_rates(turned, change)
    return after.T


class Turned(NamedTuple):
    """How three joints about x, y and z in a row, at angles a, b, c, turn a sensor."""

    quaternion: Array  # (4, n) of Rx(a) Ry(b) Rz(c)
    cos_b: Array  # (n,)
    sin_b: Array
    cos_c: Array
    sin_c: Array


def turned_by(angles: Array) -> Turned:
    """Return how angles (3, n) in rad turn a sensor."""
    (ca, cb, cc), (sa, sb, sc) = np.cos(angles / 2), np.sin(angles / 2)
    w, x, y, z = ca * cb, sa * cb, ca * sb, sa * sb  # of Rx Ry
    quaternion = np.array([w * cc - z * sc, x * cc + y * sc, y * cc - x * sc, w * sc + z * cc])
    return Turned(quaternion, (cb - sb) * (cb + sb), 2 * sb * cb, (cc - sc) * (cc + sc), 2 * sc * cc)


def joint_rates(turned: Turned, omega: Array) -> Array:
    """Return the rates (3, n) of the joints for a rate omega (3, n) of the sensor relative to its segment.

    omega = (cos b cos c, -cos b sin c, sin b) a' + (sin c, cos c, 0) b' + (0, 0, c'), in the axes of the last joint.
    """
    x, y, z = omega
    _, cb, sb, cc, sc = turned
    first = (cc * x - sc * y) / cb
    return np.array([first, sc * x + cc * y, z - sb * first])
