"""A hinge that is not quite one: segment 2 may turn across the hinge axis, R2 = R1 Ry(q) Rx(p1) Rz(p2).

With P = Rx(p1) Rz(p2), w and w' the ideal segment's rate and its derivative, and, in the axes of the turned segment,

    u   = Rz(p2)^T x p1' + z p2'                                     rate of the turn itself
    w2  = P^T w + u
    w2' = P^T w' - u x (P^T w) + Rz(p2)^T x p1'' + z p2'' - p2' z x (Rz(p2)^T x p1')

Both segments keep one origin, the joint centre. An IMU fixed at r on segment 2 feels
P^T Ry(q)^T R1^T (a - g) + w2' x r + w2 x (w2 x r).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.errors import InputError
from imubench.recording import positive
from imubench.scenarios.olsson2020.motions import OlssonMotion
from imubench.scenarios.olsson2020.session import Alter
from imubench.scenarios.olsson2020.strokes import wander
from imubench.sim.rigs import Mount, Rig, Segment
from imubench.truth import SegmentTruth, SensorTruth, Truth

CROSSING = 5.0  # Hz, critically damped: the segment crosses its play within about 0.1 s
STICKING = 0.25  # of the segment's weight times its arm: a smaller moment leaves it between the two edges
PUSHING = 1.0  # Hz at pace 1, bandwidth of hands that press the segment here and there
X, Y, Z = np.eye(3)


@dataclass(frozen=True)
class Turn:
    """The angles p1 and p2 (n, 2) in rad by which segment 2 is turned across the hinge, with derivatives."""

    angle: Array
    rate: Array
    acceleration: Array


def turned(truth: Truth, mount: Mount, turn: Turn) -> Truth:
    """Return the truth with segment 2, and the IMU on it at `mount`, turned across the hinge.

    The sensor's `joint_axis` is then the axis of segment 1's bearing as the sensor sees it. Raises `InputError` for
    a sprung mount, whose motion would have to be simulated anew.
    """
    if mount.sprung:
        raise InputError("mount of imu2: expected a rigid one under joint play, got springs")
    segment = _turned_segment(truth.segments[1], turn)
    sensor = _carried(truth, truth.sensors[1], mount, segment)
    relative = rotations.multiply(rotations.from_axis_angle(X, turn.angle[:, 0]), _about_z(turn))
    axis = rotations.rotate_back(rotations.multiply(relative, mount.quaternion), Y)
    return replace(
        truth, segments=(truth.segments[0], segment), sensors=(truth.sensors[0], replace(sensor, joint_axis=axis))
    )


def _about_z(turn: Turn) -> Array:
    return rotations.from_axis_angle(Z, turn.angle[:, 1])


def _turned_segment(ideal: SegmentTruth, turn: Turn) -> SegmentTruth:
    """Return segment 2's motion by the equations above."""
    about_z = _about_z(turn)
    P = rotations.multiply(rotations.from_axis_angle(X, turn.angle[:, 0]), about_z)
    x2 = rotations.rotate_back(about_z, X)  # segment 1's x axis, turned by q, seen from the turned segment
    own = x2 * turn.rate[:, :1] + Z * turn.rate[:, 1:]
    w, w_dot = rotations.rotate_back(P, ideal.rate), rotations.rotate_back(P, ideal.angular_acceleration)
    change = x2 * turn.acceleration[:, :1] + Z * turn.acceleration[:, 1:]
    change -= turn.rate[:, 1:] * np.cross(Z, x2 * turn.rate[:, :1])
    return replace(
        ideal,
        quaternion=rotations.multiply(ideal.quaternion, P),
        rate=w + own,
        angular_acceleration=w_dot - np.cross(own, w) + change,
    )


def _carried(truth: Truth, sensor: SensorTruth, mount: Mount, segment: SegmentTruth) -> SensorTruth:
    """Return what a sensor at a rigid mount on a segment feels."""
    w, r, R_bs = segment.rate, mount.position, rotations.to_matrix(mount.quaternion)
    arm = np.cross(segment.angular_acceleration, r) + np.cross(w, np.cross(w, r))
    gravity = np.array([0.0, 0.0, -truth.gravity])
    force = rotations.rotate_back(segment.quaternion, segment.acceleration - gravity) + arm
    return replace(
        sensor,
        position=segment.position + rotations.rotate(segment.quaternion, r),
        quaternion=rotations.multiply(segment.quaternion, mount.quaternion),
        acceleration=segment.acceleration + rotations.rotate(segment.quaternion, arm),
        gyro=w @ R_bs,
        specific_force=force @ R_bs,
        angular_acceleration=segment.angular_acceleration @ R_bs,
    )


def loaded(truth: Truth, body: Segment, limit: float) -> Turn:
    """Return the turn of a segment that gives way to its load within +- `limit` rad, in any direction.

    The load M is the moment of weight and inertia about the joint centre, its part across the hinge. The segment
    lies at p* = limit M / sqrt(|M|^2 + M0^2), M0 = STICKING m g |com|, and follows it by
    p'' = W^2 (p* - p) - 2 W p', W = 2 pi CROSSING, solved exactly for p* linear between samples.
    """
    ideal, com = truth.segments[1], body.com
    gravity = np.array([0.0, 0.0, -truth.gravity])
    felt = rotations.rotate_back(ideal.quaternion, ideal.acceleration - gravity)
    about_origin = np.diag(body.inertia) + body.mass * ((com @ com) * np.eye(3) - np.outer(com, com))
    spin = ideal.rate @ about_origin
    load = -(
        body.mass * np.cross(com, felt) + ideal.angular_acceleration @ about_origin + np.cross(ideal.rate, spin)
    )  # (n, 3) N m; `about_origin` is symmetric
    across = load[:, [0, 2]]
    sticking = STICKING * body.mass * truth.gravity * float(np.linalg.norm(com))
    target = limit * across / np.sqrt(np.sum(across**2, axis=1) + sticking**2)[:, None]
    return _followed(target, float(truth.time[1] - truth.time[0]))


def _followed(target: Array, step: float) -> Turn:
    """Return the critically damped answer to a target (n, 2) that is linear between samples `step` s apart."""
    from scipy.signal import cont2discrete, lfilter, ss2tf  # here: long to import, and most commands do without

    W = 2 * math.pi * CROSSING
    continuous = np.array([[0.0, 1.0], [-W * W, -2 * W]]), np.array([[0.0], [W * W]]), np.eye(2), np.zeros((2, 1))
    A, B, C, D, _ = cont2discrete(continuous, step, method="foh")
    numerators, denominator = ss2tf(A, B, C, D)
    moved = target - target[0]  # at rest on the first one
    angle, rate = (lfilter(b, denominator, moved, axis=0) for b in numerators)
    return Turn(angle + target[0], rate, W * W * (moved - angle) - 2 * W * rate)


def pushed(truth: Truth, rng: np.random.Generator, limit: float, bandwidth: float) -> Turn:
    """Return the turn of a segment that hands press to and fro at random, within `limit` rad in any direction."""
    end = float(truth.time[-1]) + 1.0
    values = [wander(rng, end, limit / math.sqrt(2.0), bandwidth)(truth.time) for _ in range(2)]
    return Turn(*(np.stack([v[k] for v in values], axis=-1) for k in range(3)))


def coupled(truth: Truth, coupling: Array) -> Turn:
    """Return the turn p = c q that follows the hinge angle q; `coupling` c (2,) in rad/rad."""
    assert truth.joint_angle is not None and truth.joint_rate is not None
    first, second = (s.angular_acceleration[:, 1] for s in truth.segments)
    q = truth.joint_angle, truth.joint_rate, second - first  # both share the y axis
    return Turn(*(np.multiply.outer(v, coupling) for v in q))


def play_under_load(rig: Rig, limit: float) -> Alter:
    """Return the hook for free play of +- `limit` rad taken up by weight and inertia; a tight screw closes it."""
    positive(limit, "joint play", or_zero=True)

    def alter(motion: OlssonMotion, truth: Truth, rng: np.random.Generator) -> Truth:
        return truth if motion.screw else turned(truth, rig.mounts[1], loaded(truth, rig.segments[1], limit))

    return alter


def play_under_hands(rig: Rig, limit: float) -> Alter:
    """Return the hook for free play of +- `limit` rad that hands wander through; a tight screw closes it."""
    positive(limit, "joint play", or_zero=True)

    def alter(motion: OlssonMotion, truth: Truth, rng: np.random.Generator) -> Truth:
        if motion.screw:
            return truth
        return turned(truth, rig.mounts[1], pushed(truth, rng, limit, PUSHING * motion.pace))

    return alter


def axis_coupling(rig: Rig, coupling: Array) -> Alter:
    """Return the hook for off-axis rotation p = c q; it is geometry, so a tight screw leaves it as it is."""

    def alter(motion: OlssonMotion, truth: Truth, rng: np.random.Generator) -> Truth:
        return turned(truth, rig.mounts[1], coupled(truth, coupling))

    return alter
