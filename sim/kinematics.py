"""Segments of a trajectory, without dynamics: what prescribed joints make of the segment frames."""

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.sim.motion import Trajectory
from imubench.sim.rigs import Rig
from imubench.truth import SegmentTruth


def segments_of(rig: Rig, trajectory: Trajectory) -> tuple[SegmentTruth, ...]:
    """Return the motion of a rig's segments on a trajectory.

    Segment 2 turns by the angle q about y, the hinge, in the same origin: with R = Ry(q),
    rate_2 = R^T rate_1 + q' y and rate_2' = R^T rate_1' + q'' y - q' y x R^T rate_1.
    """
    first = _first(rig, trajectory)
    if rig.family != "hinge":
        return (first,)
    angle, rate, acceleration = hinge_of(rig, trajectory)
    about_y = np.zeros((angle.size, 4))
    about_y[:, 0], about_y[:, 2] = np.cos(angle / 2), np.sin(angle / 2)
    c, s = np.cos(angle), np.sin(angle)
    w, alpha = _turn_back(c, s, first.rate), _turn_back(c, s, first.angular_acceleration)
    alpha[:, 0] -= rate * w[:, 2]
    alpha[:, 1] += acceleration
    alpha[:, 2] += rate * w[:, 0]
    w[:, 1] += rate
    second = SegmentTruth(
        "segment2",
        position=first.position,
        quaternion=rotations.multiply(first.quaternion, about_y),
        velocity=first.velocity,
        rate=w,
        acceleration=first.acceleration,
        angular_acceleration=alpha,
    )
    return first, second


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
    if rig.family == "hinge":
        return hinge_of(rig, trajectory)
    if rig.family != "pendulum":
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
    still = np.broadcast_to(np.zeros(3), t.position.shape)
    if rig.base == "fixed":
        q = np.broadcast_to(rig.base_quaternion, t.quaternion.shape)
        return SegmentTruth("segment1", still, q, still, still, still, still)
    position, velocity, acceleration = t.position, t.velocity, t.acceleration
    if rig.family == "pendulum" and not rig.pivot_moves:
        position = velocity = acceleration = still
    return SegmentTruth("segment1", position, t.quaternion, velocity, t.rate, acceleration, t.angular_acceleration)


def _turn_back(c: Array, s: Array, v: Array) -> Array:
    """Return Ry(q)^T v for cosines and sines (n,) of q."""
    return np.stack([c * v[:, 0] - s * v[:, 2], v[:, 1], s * v[:, 0] + c * v[:, 2]], axis=-1)
