"""The rigs of the fit: which splines describe their motion, and the motion of each segment from them.

A segment that turns has an attitude (a quaternion spline, its norm held at one by a prior). Its
origin has a position where one is measured, else the specific force it feels and a velocity, both
in body axes, v' + w x v = f + R' g: a position that nobody measures would have to resolve
micrometres over metres, and to turn with every change of heading. A limb on a ball joint has an
attitude alone, a hinge one angle more, a segment on a fixed base nothing.
"""

from collections.abc import Hashable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.problem.bspline import KEPT_LONG_BASES, Knots, Moment, Tracks
from imubench.jets import Jet, Turn, cross, derivatives_by, dot, follows, skew, stack, times
from imubench.links import STILL, ZERO, Link, Motion, spin
from imubench.models.tree import Tree, TreeSegment
from imubench.recording import Recording

HINGE_AXIS = 1  # +y of both segments
SWING_AXIS = 1  # +y of the world, about which a pendulum's swing is counted
ATTITUDE, POSITION, HINGE = "attitude", "position", "hinge"
FORCE, VELOCITY = "force", "velocity"


@dataclass(frozen=True)
class Rig:
    """How the first segment of a tree is held, and what hangs on it."""

    tree: Tree

    moves: bool  # segment 1's origin moves
    placed: bool  # and its position is measured
    turns: bool  # segment 1 has an attitude
    base: Array  # (3, 3) segment 1 -> world where it does not turn
    gravity: Array  # (3,) m/s^2, world

    @classmethod
    def of(cls, recording: Recording) -> "Rig":
        """Return the rig of a recording."""
        tree, turns = recording.tree, not recording.clamped
        return cls(
            tree,
            moves=turns and tree.floats,
            placed=any(p.position is not None for p in recording.poses),
            turns=turns,
            base=rotations.to_matrix(recording.base_quaternion),
            gravity=np.array([0.0, 0.0, -recording.gravity]),
        )

    @property
    def hinge(self) -> bool:
        """Whether the last segment turns about +y on the one that holds it."""
        return self.tree.hinge is not None

    @property
    def ball(self) -> bool:
        """Whether the last segment turns on a ball joint."""
        return self.tree.ball is not None

    @property
    def content(self) -> tuple[Hashable, ...]:
        """All that it is, as what is kept of it is found by."""
        return self.tree, self.moves, self.placed, self.turns, self.base.tobytes(), self.gravity.tobytes()

    @property
    def widths(self) -> dict[str, int]:
        """The splines and their widths."""
        unplaced = self.moves and not self.placed
        every = {
            ATTITUDE: (4, self.turns),
            POSITION: (3, self.moves and self.placed),
            FORCE: (3, unplaced),
            VELOCITY: (3, unplaced),
            **{self.angle_of(segment): (1, True) for segment in self.tree.segments[1:]},
        }
        return {name: width for name, (width, there) in every.items() if there}

    def first(self, moment: Moment, gravity: Jet | None = None) -> Motion:
        """Return segment 1's motion, its origin at the joint centre; `gravity` (1, 3) where it is not the rig's."""
        down = gravity or Jet(self.gravity[None])
        if not self.turns:
            turn = Turn(self.base[None])
            return Motion(ZERO, ZERO, turn.back(-down), turn, ZERO)
        turn, rate, accel = turning(moment)
        if not self.moves:
            return Motion(rate, accel, turn.back(-down), turn, ZERO)
        if not self.placed:
            return Motion(rate, accel, moment.track(FORCE), turn)
        return Motion(rate, accel, turn.back(moment.track(POSITION, 2) - down), turn, moment.track(POSITION))

    def angle_of(self, segment: TreeSegment) -> str:
        """Return the name of the spline of the angle by which a segment turns on the one that holds it."""
        return HINGE if segment is self.tree.last else segment.joints[-1].name

    def joint(self, moment: Moment, segment: TreeSegment) -> Link:
        """Return a segment on the one that holds it; the first one's joint is in what `first` returns."""
        if segment.parent is None:
            return Link(STILL)
        return spin(HINGE_AXIS, *(moment.track(self.angle_of(segment), order) for order in range(3)))


def turning(moment: Moment) -> tuple[Turn, Jet, Jet]:
    """Return rotation, rate and angular acceleration of segment 1, not to be written to: the last few are kept.

    Two IMUs of one rate, laws and priors ask for the same one after another.
    """
    if moment.time.blocks:
        return attitude(*(moment.track(ATTITUDE, order) for order in range(3)))
    q = np.ascontiguousarray(moment.coefficients[:, moment.tracks.columns(ATTITUDE)])
    return _turning(moment.tracks.knots, moment.time.value.tobytes(), q.tobytes(), follows(ATTITUDE))


@lru_cache(KEPT_LONG_BASES)
def _turning(knots: Knots, time: bytes, q: bytes, followed: bool) -> tuple[Turn, Jet, Jet]:
    alone = Moment(Tracks(knots, {ATTITUDE: 4}), np.frombuffer(q).reshape(-1, 4), Jet(np.frombuffer(time)[:, None]))
    with derivatives_by((ATTITUDE,) if followed else ()):
        return attitude(*(alone.track(ATTITUDE, order) for order in range(3)))


def attitude(q: Jet, q_rate: Jet, q_accel: Jet) -> tuple[Turn, Jet, Jet]:
    """Return rotation, rate and angular acceleration in body axes from a quaternion (n, 4) of any norm.

    With n = |q|^2: w = 2 Im(q* q') / n, and since Im(q'* q') = 0, w' = 2 Im(q* q'') / n - w n' / n.
    """
    norm = dot(q, q)
    rate = 2.0 * imaginary(q, q_rate) / norm
    accel = 2.0 * imaginary(q, q_accel) / norm - rate * (2.0 * dot(q, q_rate) / norm)
    value = q.value
    unit = value / np.linalg.norm(value, axis=1, keepdims=True)
    right = np.concatenate([-value[:, 1:, None], value[:, :1, None] * np.eye(3) - skew(value[:, 1:])], axis=2) * (
        2 / norm.value[:, :, None]
    )
    turn = Turn(rotations.to_matrix(unit), {key: times(right, d) for key, d in q.blocks.items()})
    return turn, rate, accel


def imaginary(a: Jet, b: Jet) -> Jet:
    """Return the vector part (n, 3) of a* b for quaternions (n, 4)."""
    return a[[0, 0, 0]] * b[[1, 2, 3]] - b[[0, 0, 0]] * a[[1, 2, 3]] - cross(a[[1, 2, 3]], b[[1, 2, 3]])


def swing(segment: Motion) -> tuple[Jet, Jet, Jet]:
    """Return a pendulum's swing atan2(R02, R22) (n, 1) rad and its first two derivatives.

    With u the limb's z axis in the world, u' = R (w x e), u'' = R (w' x e + w x (w x e)), and h = u0^2 + u2^2:
    s' = (u2 u0' - u0 u2') / h, s'' = (u2 u0'' - u0 u2'' - s' h') / h.
    """
    assert segment.turn is not None
    up = Jet(np.array([[0.0, 0.0, 1.0]]))
    moved = cross(segment.rate, up)
    u, u1, u2 = (segment.turn.forth(v) for v in (up, moved, cross(segment.accel, up) + cross(segment.rate, moved)))
    x, z = u[[0]], u[[2]]
    square = x * x + z * z
    rate = (z * u1[[0]] - x * u1[[2]]) / square
    growth = 2.0 * (x * u1[[0]] + z * u1[[2]])
    accel = (z * u2[[0]] - x * u2[[2]] - rate * growth) / square
    slope = stack(z, -x) / square
    blocks = {key: np.sum(slope.value[:, :, None] * d, axis=1, keepdims=True) for key, d in stack(x, z).blocks.items()}
    return Jet(np.arctan2(x.value, z.value), blocks), rate, accel
