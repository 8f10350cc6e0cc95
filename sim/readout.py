"""MuJoCo's sensor data, sample by sample, become Truth."""

from typing import Any

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.sim.kinematics import hinge_of, segments_of
from imubench.sim.motion import Trajectory
from imubench.sim.rigs import Mount, Rig
from imubench.truth import SegmentTruth, SensorTruth, Truth

HINGE_AXIS = np.array([0.0, 1.0, 0.0])  # in both segment frames


def read_truth(
    rig: Rig,
    model: Any,
    time: Array,
    sensordata: Array,
    labels: tuple[tuple[str, float, float], ...] = (),
    played: Trajectory | None = None,
) -> Truth:
    """Return the truth of `sensordata` (n, nsensordata), recorded at `time` (n,) s on a model of `rig`.

    Segments are read from the trajectory that was `played`, or from their sensors where there is none or a play adds
    to it.
    """

    def column(name: str) -> Array:
        sensor = model.sensor(name)
        return sensordata[:, sensor.adr[0] : sensor.adr[0] + sensor.dim[0]]

    # MuJoCo's frame accelerations are what an accelerometer would read: they contain -g.
    gravity_w = np.array([0.0, 0.0, -rig.gravity])
    if played is None or rig.loose is not None:
        segments = tuple(_read_segment(name, column, gravity_w) for name in rig.tree.names)
    else:
        segments = segments_of(rig, played)
    sensors = tuple(
        _read_sensor(f"imu{i + 1}", mount, segments[i], segments[0], column, gravity_w, rig)
        for i, mount in enumerate(rig.mounts)
    )
    return truth_of(rig, time, segments, sensors, labels, played)


def truth_of(
    rig: Rig,
    time: Array,
    segments: tuple[SegmentTruth, ...],
    sensors: tuple[SensorTruth, ...],
    labels: tuple[tuple[str, float, float], ...] = (),
    played: Trajectory | None = None,
) -> Truth:
    """Return segments and sensors as the truth of a rig, the angle of its hinge with them."""
    angle = rate = None
    if rig.tree.hinge is not None:
        angle, rate = _hinge_angle(segments[0], segments[1]) if played is None else hinge_of(rig, played)[:2]
    return Truth(time, rig.family, rig.gravity, segments, sensors, angle, rate, labels)


def _read_segment(name: str, column: Any, gravity_w: Array) -> SegmentTruth:
    q = column(f"{name}_framequat")
    return SegmentTruth(
        name,
        position=column(f"{name}_framepos"),
        quaternion=q,
        velocity=column(f"{name}_framelinvel"),
        rate=column(f"{name}_gyro"),
        acceleration=column(f"{name}_framelinacc") + gravity_w,
        angular_acceleration=rotations.rotate_back(q, column(f"{name}_frameangacc")),
    )


def _read_sensor(
    name: str, mount: Mount, segment: SegmentTruth, base: SegmentTruth, column: Any, gravity_w: Array, rig: Rig
) -> SensorTruth:
    position, q = column(f"{name}_framepos"), column(f"{name}_framequat")
    loose = segment is not base and (rig.wanders or rig.play is not None)  # it turns about axes that are not its own
    if mount.moves or loose:
        angular = rotations.rotate_back(q, column(f"{name}_frameangacc"))
        joint_vector = rotations.rotate_back(q, segment.position - position)
        axis = rotations.rotate_back(q, rotations.rotate((base if loose else segment).quaternion, HINGE_AXIS))
        displacement = rotations.rotate_back(segment.quaternion, position - segment.position) - mount.position
        relative = rotations.multiply(rotations.conjugate(segment.quaternion), q)
        turned = rotations.log(rotations.multiply(rotations.conjugate(mount.quaternion), relative))
    else:
        R_bs = rotations.to_matrix(mount.quaternion)
        angular = segment.angular_acceleration @ R_bs
        joint_vector = np.broadcast_to(-mount.position @ R_bs, q[:, 1:].shape)
        axis = np.broadcast_to(HINGE_AXIS @ R_bs, q[:, 1:].shape)
        displacement = turned = np.broadcast_to(np.zeros(3), q[:, 1:].shape)
    return SensorTruth(
        name,
        position=position,
        quaternion=q,
        acceleration=column(f"{name}_framelinacc") + gravity_w,
        gyro=column(f"{name}_gyro"),
        specific_force=column(f"{name}_accelerometer"),
        angular_acceleration=angular,
        joint_vector=joint_vector,
        joint_axis=axis if rig.tree.hinge is not None else None,
        displacement=displacement,
        rotation=turned,
    )


def _hinge_angle(first: SegmentTruth, second: SegmentTruth) -> tuple[Array, Array]:
    w1, x1, y1, z1 = first.quaternion.T
    w2, x2, y2, z2 = second.quaternion.T
    cosine = w1 * w2 + x1 * x2 + y1 * y2 + z1 * z2  # of half the angle: the product conj(q1) q2 = (cos, 0, sin, 0)
    sine = w1 * y2 - y1 * w2 + x1 * z2 - z1 * x2
    return np.unwrap(2 * np.arctan2(sine, cosine)), second.rate[:, 1] - first.rate[:, 1]
