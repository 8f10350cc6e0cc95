"""Frames that move relative to each other: one rule carries rates and specific force along a chain.

A `Motion` is a body's: angular rate w, angular acceleration w', specific force f at its origin,
all in body axes. A `Link` is a child frame's pose in its parent and that pose's time derivatives.
With R: child -> parent, d the child's origin in the parent, r the child's rate relative to the parent
in child axes::

    w_child = R' w + r
    w'_child = R' w' + (R' w) x r + r'
    f_child = R' (f + w' x d + w x (w x d) + 2 w x d' + d'')

Segment on joint, sensor on mount, sensor on a moving mount: all are the same rule.
"""

from dataclasses import dataclass

import numpy as np

from imubench.jets import Jet, Turn, cross, jet, rotation

ZERO = Jet(np.zeros((1, 3)))
STILL = Turn(np.eye(3)[None])


@dataclass(frozen=True)
class Link:
    """A child frame in its parent; every vector (n or 1, 3)."""

    turn: Turn = STILL  # child -> parent
    rate: Jet = ZERO  # rad/s, child axes
    accel: Jet = ZERO  # rad/s^2, derivative of `rate`'s components
    offset: Jet = ZERO  # m, parent axes
    offset_rate: Jet = ZERO  # m/s
    offset_accel: Jet = ZERO  # m/s^2

    def __matmul__(self, inner: "Link") -> "Link":
        """Return the link to `inner`'s child, which hangs on this link's child."""
        carried = inner.turn.back(self.rate)
        moved, arm = self.turn.forth(self.rate), self.turn.forth(inner.offset)
        arm_rate = self.turn.forth(inner.offset_rate)
        spin = self.turn.forth(self.accel)
        return Link(
            self.turn @ inner.turn,
            carried + inner.rate,
            inner.turn.back(self.accel) + cross(carried, inner.rate) + inner.accel,
            self.offset + arm,
            self.offset_rate + cross(moved, arm) + arm_rate,
            self.offset_accel
            + cross(spin, arm)
            + cross(moved, cross(moved, arm))
            + 2.0 * cross(moved, arm_rate)
            + self.turn.forth(inner.offset_accel),
        )


@dataclass(frozen=True)
class Motion:
    """A body's motion, in its own axes."""

    rate: Jet  # (n, 3) rad/s
    accel: Jet  # (n, 3) rad/s^2
    force: Jet  # (n, 3) m/s^2, specific force at the origin
    turn: Turn | None = None  # body -> world, where an attitude is known
    position: Jet | None = None  # (n, 3) m, world, where it is known

    def child(self, link: Link) -> "Motion":
        """Return the motion of the frame at the end of `link`."""
        rate = link.turn.back(self.rate)
        d = link.offset
        force = (
            self.force
            + cross(self.accel, d)
            + cross(self.rate, cross(self.rate, d))
            + 2.0 * cross(self.rate, link.offset_rate)
            + link.offset_accel
        )
        return Motion(
            rate + link.rate,
            link.turn.back(self.accel) + cross(rate, link.rate) + link.accel,
            link.turn.back(force),
            None if self.turn is None else self.turn @ link.turn,
            None if self.turn is None or self.position is None else self.position + self.turn.forth(d),
        )


def spin(axis: int, angle: Jet, rate: Jet, accel: Jet) -> Link:
    """Return the link that turns about coordinate axis 0, 1 or 2 by an angle (n, 1) and its derivatives."""
    unit = np.eye(3)[:, [axis]]
    return Link(rotation(angle.at(unit)), rate.at(unit), accel.at(unit))


def small_turn(vector: Jet, rate: Jet, accel: Jet) -> Link:
    """Return the link that turns by a rotation vector v (n, 3) and its derivatives.

    Its rate is Jr(v) v' to third order in v: off by v^3 / 24 of v' (1e-4 at 0.15 rad).
    """
    v_rate = cross(vector, rate)
    return Link(
        rotation(vector),
        rate - 0.5 * v_rate + cross(vector, v_rate) * (1 / 6),
        accel - 0.5 * cross(vector, accel) + (cross(rate, v_rate) + cross(vector, cross(vector, accel))) * (1 / 6),
    )


def shift(offset: Jet, rate: Jet | None = None, accel: Jet | None = None) -> Link:
    """Return the link that moves the origin (n, 3) m and leaves the axes."""
    return Link(offset=jet(offset), offset_rate=rate or ZERO, offset_accel=accel or ZERO)
