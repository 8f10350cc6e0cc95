"""Segments of a trajectory, without dynamics: what prescribed joints make of the segment frames."""

from dataclasses import replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.sim.motion import Trajectory
from imubench.sim.rigs import Rig
from imubench.truth import SegmentTruth


def segments_of(rig: Rig, trajectory: Trajectory) -> tuple[SegmentTruth, ...]:
    """Return the motion of a rig's segments on a trajectory, that of a loose limb apart: it follows by forces.

    Segment 2 turns by the angle q about y, the hinge, in the same origin: with R = Ry(q),
    rate_2 = R^T rate_1 + q' y and rate_2' = R^T rate_1' + q'' y - q' y x R^T rate_1. An origin that moves and turns
    that are geared to the angle come on top (see `sim.joints`).
    """
    first = _first(rig, trajectory)
    if rig.tree.hinge is None:
        return (first,)
    course = hinge_of(rig, trajectory)
    second = replace(first, name=rig.tree.last.name)
    if rig.centre.any():
        second = _shifted(second, course, rig.centre)
    second = _hinged(second, *course)
    for axis, gear in zip((0, 2), rig.coupling, strict=True):
        if rig.coupling.any():
            second = _turned(second, np.eye(3)[axis], *(gear * x for x in course))
    if rig.play is not None and rig.play.path is not None:
        for along, signal in zip((rig.play.axis, rig.play.beside), rig.play.path, strict=True):
            second = _turned(second, along, *signal(trajectory.time))
    return first, second


def _hinged(frame: SegmentTruth, angle: Array, rate: Array, acceleration: Array) -> SegmentTruth:
    """Return a frame turned about its y axis by an angle (n,) with its derivatives."""
    about_y = np.zeros((angle.size, 4))
    about_y[:, 0], about_y[:, 2] = np.cos(angle / 2), np.sin(angle / 2)
    c, s = np.cos(angle), np.sin(angle)
    w, alpha = _turn_back(c, s, frame.rate), _turn_back(c, s, frame.angular_acceleration)
    alpha[:, 0] -= rate * w[:, 2]
    alpha[:, 1] += acceleration
    alpha[:, 2] += rate * w[:, 0]
    w[:, 1] += rate
    quaternion = rotations.multiply(frame.quaternion, about_y)
    return replace(frame, quaternion=quaternion, rate=w, angular_acceleration=alpha)


def _shifted(frame: SegmentTruth, course: tuple[Array, Array, Array], centre: Array) -> SegmentTruth:
    """Return segment 2's frame before it turns, its origin at d = `centre` q (n, 3) in `frame`.

    v = v_1 + R (w x d + d'),  a = a_1 + R (w' x d + w x (w x d) + 2 w x d' + d'').
    """
    d, d1, d2 = (np.outer(x, centre) for x in course)
    w, alpha = frame.rate, frame.angular_acceleration
    across = np.cross(w, d)
    pushed = np.cross(alpha, d) + np.cross(w, across) + 2 * np.cross(w, d1) + d2
    at, velocity, acceleration = (rotations.rotate(frame.quaternion, v) for v in (d, across + d1, pushed))
    return replace(
        frame,
        position=frame.position + at,
        velocity=frame.velocity + velocity,
        acceleration=frame.acceleration + acceleration,
    )


def _turned(frame: SegmentTruth, axis: Array, angle: Array, rate: Array, acceleration: Array) -> SegmentTruth:
    """Return a frame turned about one of its axes e: w_2 = Q^T w + x' e,  w_2' = Q^T w' + x'' e - x' e x Q^T w."""
    q = rotations.exp(np.outer(angle, axis))
    w, alpha = rotations.rotate_back(q, frame.rate), rotations.rotate_back(q, frame.angular_acceleration)
    turning = rate[:, None] * axis
    return replace(
        frame,
        quaternion=rotations.multiply(frame.quaternion, q),
        rate=w + turning,
        angular_acceleration=alpha + acceleration[:, None] * axis - np.cross(turning, w),
    )


def hinge_of(rig: Rig, trajectory: Trajectory) -> tuple[Array, Array, Array]:
    """Return hinge angle, rate and acceleration, each (n,): the trajectory's, or those of a screwed joint."""
    if rig.locked_at is None:
        return trajectory.angle, trajectory.angle_rate, trajectory.angle_acceleration
    still = np.zeros(trajectory.time.size)
    return still + rig.locked_at, still, still


def turned(rig: Rig, trajectory: Trajectory) -> tuple[Array, Array, Array]:
    """Return the angle (n,) by which a rig's joint is turned, and its derivatives: what skin slides with.

    The hinge angle; of the pendulum the swing atan2(R[0, 2], R[2, 2]), without jumps; zero on a free body.
    With r = R e_z: r' = R (w x e_z) and r'' = R (w' x e_z + w x (w x e_z)).
    """
    if rig.tree.hinge is not None:
        return hinge_of(rig, trajectory)
    if rig.tree.ball is None:
        still = np.zeros(trajectory.time.size)
        return still, still, still
    w, up = trajectory.rate, np.array([0.0, 0.0, 1.0])
    across = np.cross(w, up)
    parts = (up, across, np.cross(trajectory.angular_acceleration, up) + np.cross(w, across))
    (x, z), (dx, dz), (ddx, ddz) = (rotations.rotate(trajectory.quaternion, v)[:, [0, 2]].T for v in parts)
    size = x**2 + z**2
    rate = (z * dx - x * dz) / size
    second = (z * ddx - x * ddz - 2 * rate * (x * dx + z * dz)) / size
    return np.unwrap(np.arctan2(x, z)), rate, second


def _first(rig: Rig, t: Trajectory) -> SegmentTruth:
    still, name = np.broadcast_to(np.zeros(3), t.position.shape), rig.tree.names[0]
    if rig.base == "fixed":
        q = np.broadcast_to(rig.base_quaternion, t.quaternion.shape)
        return SegmentTruth(name, still, q, still, still, still, still)
    position, velocity, acceleration = t.position, t.velocity, t.acceleration
    if not rig.tree.floats and not rig.pivot_moves:
        position = velocity = acceleration = still
    return SegmentTruth(name, position, t.quaternion, velocity, t.rate, acceleration, t.angular_acceleration)


def _turn_back(c: Array, s: Array, v: Array) -> Array:
    """Return Ry(q)^T v for cosines and sines (n,) of q."""
    return np.stack([c * v[:, 0] - s * v[:, 2], v[:, 1], s * v[:, 0] + c * v[:, 2]], axis=-1)
