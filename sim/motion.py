"""A motion says where every joint is at any time, with exact rates and accelerations."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.sim.signals import STILL, Signal


@dataclass(frozen=True)
class Trajectory:
    """The joints of a rig at given times.

    Position and velocity are those of segment 1's frame (a fixed base's stays put, and a pendulum's unless it is said
    that its pivot moves).
    """

    time: Array  # (n,) s
    position: Array  # (n, 3) m, world
    velocity: Array  # (n, 3) m/s, world
    acceleration: Array  # (n, 3) m/s^2, world
    quaternion: Array  # (n, 4) segment 1 -> world
    rate: Array  # (n, 3) rad/s, segment axes
    angular_acceleration: Array  # (n, 3) rad/s^2, segment axes
    angle: Array  # (n,) rad, hinge
    angle_rate: Array  # (n,) rad/s
    angle_acceleration: Array  # (n,) rad/s^2


Motion = Callable[[Array], Trajectory]
"""Takes times (n,) in s; returns the trajectory there."""


@dataclass(frozen=True)
class AngleMotion:
    """Segment 1 turns as R_wb = Rz(heading) Rx(tilt) Ry(spin), moves along x, y, z; the hinge bends by `angle`.

    With tilt 0 the segment's y axis, the hinge, is horizontal; spin turns about it.
    """

    heading: Signal = STILL  # rad
    tilt: Signal = STILL  # rad
    spin: Signal = STILL  # rad
    angle: Signal = STILL  # rad
    x: Signal = STILL  # m
    y: Signal = STILL  # m
    z: Signal = STILL  # m

    def __call__(self, time: Array) -> Trajectory:
        """Return the trajectory at `time` (n,) s."""
        a, da, dda = self.heading(time)
        b, db, ddb = self.tilt(time)
        c, dc, ddc = self.spin(time)
        half = [(np.cos(angle / 2), np.sin(angle / 2)) for angle in (a, b, c)]
        rate, angular = _rates(half[1:], (da, db, dc), (dda, ddb, ddc))
        position, velocity, acceleration = (
            np.stack(parts, axis=-1) for parts in zip(self.x(time), self.y(time), self.z(time), strict=True)
        )
        return Trajectory(time, position, velocity, acceleration, _quaternion(half), rate, angular, *self.angle(time))


@dataclass(frozen=True)
class Later:
    """A motion from `start` s on."""

    motion: "Motion"
    start: float  # s

    def __call__(self, time: Array) -> Trajectory:
        """Return the coordinates at `time` s from its own start."""
        return self.motion(time + self.start)


@dataclass(frozen=True)
class Carried:
    """A motion whose position is that of another: what it does is done on a moving origin."""

    motion: Motion
    x: Signal  # m, world
    y: Signal
    z: Signal

    def __call__(self, time: Array) -> Trajectory:
        """Return the trajectory at `time` (n,) s."""
        parts = zip(self.x(time), self.y(time), self.z(time), strict=True)
        position, velocity, acceleration = (np.stack(part, axis=-1) for part in parts)
        return replace(self.motion(time), position=position, velocity=velocity, acceleration=acceleration)


def _quaternion(half: Sequence[tuple[Array, Array]]) -> Array:
    """Return the quaternion of Rz(a) Rx(b) Ry(c) from cosines and sines of half the angles."""
    (ca, sa), (cb, sb), (cc, sc) = half
    w, x, y, z = ca * cb, ca * sb, sa * sb, sa * cb  # of Rz Rx
    return np.stack([w * cc - y * sc, x * cc - z * sc, w * sc + y * cc, x * sc + z * cc], axis=-1)


def _rates(
    half: Sequence[tuple[Array, Array]], first: tuple[Array, Array, Array], second: tuple[Array, Array, Array]
) -> tuple[Array, Array]:
    """Return angular rate and acceleration in segment axes; `half` as in `_quaternion`, of b and c.

    w = da (-sin c cos b, sin b, cos c cos b) + db (cos c, 0, sin c) + dc (0, 1, 0), and its derivative.
    """
    (cb, sb), (cc, sc) = (((c - s) * (c + s), 2 * s * c) for c, s in half)
    da, db, dc = first
    dda, ddb, ddc = second
    rate = np.stack([-da * sc * cb + db * cc, da * sb + dc, da * cc * cb + db * sc], axis=-1)
    wx = -dda * sc * cb + ddb * cc + da * (-dc * cc * cb + db * sc * sb) - db * dc * sc
    wy = dda * sb + ddc + da * db * cb
    wz = dda * cc * cb + ddb * sc - da * (dc * sc * cb + db * cc * sb) + db * dc * cc
    return rate, np.stack([wx, wy, wz], axis=-1)
