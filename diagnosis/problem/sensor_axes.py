"""The axes of segment 1's sensor, in which what is known of the motion stays as it is when the sensor's mount turns.

A mount is hardly held, its sensor's own attitude is: when a step turns the mount, the segment turns back.
"""

from collections.abc import Mapping

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.problem.hypothesis import Geometry, Hypothesis
from imubench.diagnosis.problem.rig_kinematics import Rig
from imubench.effects import EFFECTS
from imubench.jets import CONSTANT, Jet, Turn, rotation, skew, times, variable

Mounts = Mapping[str, Geometry]
"""The mounts that the fit starts from, by IMU."""


def first_sensor(rig: Rig, mounts: Mounts) -> str | None:
    """Return the name of segment 1's IMU; None where it has none."""
    return next((imu.name for imu in rig.tree.segments[0].imus if imu.name in mounts), None)


def turning(sensor: str) -> tuple[str, ...]:
    """Return the names of the numbers that turn a sensor: its mount's error, and what effects have it turned by."""
    placing = (Hypothesis(effect, sensor) for effect in EFFECTS.values() if effect.misplaces)
    return (f"{sensor}.rotation", *(h.key("rotation") for h in placing))


def sensor_turn(rig: Rig, mounts: Mounts, values: Mapping[str, Array]) -> Turn:
    """Return the sensor's axes in the segment's, without what moves them.

    For the priors: in the segment's own axes what they leave would turn with the mount, at no cost, and Gauss-Newton
    would take that for knowledge: 0.16 rad of a turn about the hinge, of which nothing but the mount's prior knows.
    """
    sensor = first_sensor(rig, mounts)
    if sensor is None:
        return Turn(np.eye(3)[None])
    turn = Turn(mounts[sensor].turn[None])
    for name in turning(sensor):
        if name in values:
            turn = turn @ rotation(variable((name, CONSTANT), values[name]))
    return turn


def turned(q: Jet, by: Turn) -> Jet:
    """Return quaternions (n, 4), or derivatives of some, times the one of a rotation from the right."""
    m, units = rotations.from_matrix(by.matrix), np.eye(4)[:, None]
    value = rotations.multiply(q.value, m)
    right = np.stack([rotations.multiply(u, m) for u in units], axis=2)
    half = np.stack([rotations.multiply(value, u) for u in units[1:]], axis=2) / 2
    blocks = {key: times(right, d) for key, d in q.blocks.items()}
    return Jet(value, blocks | {key: times(half, d) for key, d in by.blocks.items()})


def turns_back(rig: Rig, mounts: Mounts, old: Mapping[str, Array], new: Mapping[str, Array]) -> tuple[Array, Array]:
    """Return how segment 1 turns where its sensor stays: a matrix (3, 3), and to first order a vector (3,) rad."""
    sensor, slope = first_sensor(rig, mounts), np.zeros(3)
    if sensor is None:
        return np.eye(3), slope
    before = after = mounts[sensor].turn
    for name in turning(sensor):
        if name in new:
            slope -= before @ left_jacobian(old[name]) @ (new[name] - old[name])
            before, after = (m @ rotations.to_matrix(rotations.exp(v[name])) for m, v in ((before, old), (after, new)))
    return before @ after.T, slope


def left_jacobian(rotation: Array) -> Array:
    """Return J (3, 3) of exp(r + d) = exp(J d) exp(r), to first order in d (3,) rad."""
    angle, (across,) = float(np.linalg.norm(rotation)), skew(rotation[None])
    if angle < 1e-6:
        return np.asarray(np.eye(3) + across / 2)
    share = np.sin(angle) / angle
    along = np.outer(rotation, rotation) / angle**2
    return np.asarray(share * np.eye(3) + (1 - share) * along + (1 - np.cos(angle)) / angle**2 * across)
