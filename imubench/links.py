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
        carried = _back(inner.turn, self.rate)
        moved, arm = _forth(self.turn, self.rate), _forth(self.turn, inner.offset)
        arm_rate = _forth(self.turn, inner.offset_rate)
        spin = _forth(self.turn, self.accel)
        whirled = _across(moved, arm)
        return Link(
            inner.turn if self.turn is STILL else self.turn if inner.turn is STILL else self.turn @ inner.turn,
            _total(carried, inner.rate),
            _total(_back(inner.turn, self.accel), _across(carried, inner.rate), inner.accel),
            _total(self.offset, arm),
            _total(self.offset_rate, whirled, arm_rate),
            _total(
                self.offset_accel,
                _across(spin, arm),
                _across(moved, whirled),
                _twice(_across(moved, arm_rate)),
                _forth(self.turn, inner.offset_accel),
            ),
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
        rate = _back(link.turn, self.rate)
        d = link.offset
        force = _total(
            self.force,
            _across(self.accel, d),
            _across(self.rate, _across(self.rate, d)),
            _twice(_across(self.rate, link.offset_rate)),
            link.offset_accel,
        )
        return Motion(
            _total(rate, link.rate),
            _total(_back(link.turn, self.accel), _across(rate, link.rate), link.accel),
            _back(link.turn, force),
            self.turn if self.turn is None or link.turn is STILL else self.turn @ link.turn,
            None if self.turn is None or self.position is None else self.position + self.turn.forth(d),
        )


def _across(a: Jet, b: Jet) -> Jet:
    """Return a x b, `ZERO` where one of them is: most links move in few ways, and nought need not be multiplied."""
    return ZERO if a is ZERO or b is ZERO else cross(a, b)


def _total(*vectors: Jet) -> Jet:
    """Return the sum of vectors, those left out that are `ZERO`."""
    some = [v for v in vectors if v is not ZERO]
    return sum(some[1:], some[0]) if some else ZERO


def _twice(vector: Jet) -> Jet:
    return vector if vector is ZERO else 2.0 * vector


def _back(turn: Turn, vector: Jet) -> Jet:
    """Return R' v, and v itself where nothing turns."""
    return vector if turn is STILL or vector is ZERO else turn.back(vector)


def _forth(turn: Turn, vector: Jet) -> Jet:
    """Return R v, and v itself where nothing turns."""
    return vector if turn is STILL or vector is ZERO else turn.forth(vector)


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
