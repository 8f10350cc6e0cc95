"""What sensors on sprung mounts read, from where their springs are and how fast they move: Newton's and Euler's laws.

Per unit of mass springs pull with s = -(W^2 q + 2 Z W q'), W = 2 pi f, along or about each of their joints q. With
f specific forces, w and w' the sensor's rate and its derivative, r the pivot, c the centre of mass from there, k the
radius of gyration about the pivot, the same about every axis, and J the joints' axes (omega = J q'):

    translation   f_c = s                            (springs alone hold the centre of mass)
    rotation      k^2 w' = J^-T s - c x f_r          (about the pivot no inertia turns with w)

and f at any other point of a rigid body follows from w and w'. Rotation alone has f_r from the segment. With both, f_r
from f_c gives (k^2 - c^2) w' + c (c . w') = J^-T s - c x (f_c - w x (w x c)).
`driven.evaluate` and `readout` have the same from MuJoCo's own sensors, in six times the time.
"""

from typing import NamedTuple

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.sim.jolt import turned_by
from imubench.sim.rigs import Mount, Rig, Spring
from imubench.sim.threes import carried, cross, matrix, product, rows, turn, turn_back
from imubench.truth import SegmentTruth, SensorTruth


class _Turning(NamedTuple):
    """A sensor on its rotational springs: how it is turned, and what about it is known without forces."""

    quaternion: Array  # (4, n) to where it is unloaded
    omega: Array  # (3, n) rad/s, relative to the segment, sensor axes
    pull: Array  # (3, n) N m/kg, J^-T s, sensor axes


def read_mounts(
    rig: Rig, segments: tuple[SegmentTruth, ...], positions: Array, velocities: Array
) -> tuple[SensorTruth, ...]:
    """Return the truth of a rig's sensors on springs (or rigid ones) from their joints' state, each (n, mounts).

    `segments` move with their true rates. Mounts that slide as they are told are not for here.
    """
    x, v = rows(positions), rows(velocities)
    each = zip(rig.mounts, rig.spring_columns, segments, strict=False)
    return tuple(_read(f"imu{i}", mount, at, x[own], v[own], rig) for i, (mount, own, at) in enumerate(each, 1))


def _read(name: str, mount: Mount, segment: SegmentTruth, x: Array, v: Array, rig: Rig) -> SensorTruth:
    still = np.zeros((3, len(segment.position)))
    gravity_w, lever = np.array([[0.0], [0.0], [-rig.gravity]]), mount.lever[:, None]
    quaternion, own = rows(segment.quaternion), mount.quaternion[:, None]
    R_wb, w, alpha = matrix(quaternion), rows(segment.rate), rows(segment.angular_acceleration)
    moved = still if mount.translation is None else x[:3]
    pivot = (mount.position - rotations.rotate(mount.quaternion, mount.lever))[:, None] + moved
    turning = None if mount.rotation is None else _turning(mount.rotation, x[-3:], v[-3:], mount.gyration)
    q_bs = own if turning is None else product(own, turning.quaternion)
    R_bs = matrix(q_bs)
    w = turn_back(R_bs, w) if turning is None else turn_back(R_bs, w) + turning.omega
    alpha_b = turn_back(R_bs, alpha)
    if mount.translation is not None:
        base, held = mount.com[:, None], turn_back(R_bs, _pull(mount.translation, x[:3], v[:3]))
    else:
        at_pivot = carried(turn_back(R_wb, rows(segment.acceleration) - gravity_w), rows(segment.rate), alpha, pivot)
        base, held = np.zeros((3, 1)), turn_back(R_bs, at_pivot)
    angular = alpha_b if turning is None else _angular(mount, turning, held, w)
    force = carried(held, w, angular, lever - base)
    at = pivot + turn(R_bs, lever)
    axis = np.broadcast_to(R_bs[1], still.shape).T if rig.tree.hinge is not None else None
    return SensorTruth(
        name,
        position=(rows(segment.position) + turn(R_wb, at)).T,
        quaternion=product(quaternion, q_bs).T,
        acceleration=(turn(R_wb, turn(R_bs, force)) + gravity_w).T,
        gyro=w.T,
        specific_force=force.T,
        angular_acceleration=angular.T,
        joint_vector=-turn_back(R_bs, at).T,
        joint_axis=axis,
        displacement=(at - mount.position[:, None]).T,
        rotation=still.T if turning is None else rotations.log(turning.quaternion.T),
    )


def _pull(spring: Spring, x: Array, v: Array) -> Array:
    """Return -(W^2 x + 2 Z W x') (3, n) of springs at x that change with v (3, n)."""
    W = 2 * np.pi * spring.frequency
    return -((W**2)[:, None] * x + (2 * spring.damping_ratio * W)[:, None] * v)


def _turning(spring: Spring, x: Array, v: Array, gyration: float) -> _Turning:
    """Return the state of three joints about x, y and z in a row (see `jolt.joint_rates` for their axes J)."""
    quaternion, cb, sb, cc, sc = turned_by(x)
    ahead = cb * v[0]
    omega = np.array([cc * ahead + sc * v[1], cc * v[1] - sc * ahead, sb * v[0] + v[2]])
    first, second, third = _pull(spring, x, v) * gyration**2
    first = (first - sb * third) / cb
    return _Turning(quaternion, omega, np.array([cc * first + sc * second, cc * second - sc * first, third]))


def _angular(mount: Mount, turning: _Turning, held: Array, w: Array) -> Array:
    """Return w' (3, n) of a sensor on rotational springs; `held` is f_c if it slides too, else f_r, sensor axes."""
    c = mount.com[:, None]
    if mount.translation is None:
        return (turning.pull - cross(c, held)) / mount.gyration**2
    drive = turning.pull - cross(c, held - cross(w, cross(w, c)))
    along = mount.com @ drive
    return (drive - c * along / mount.gyration**2) / (mount.gyration**2 - mount.com @ mount.com)
