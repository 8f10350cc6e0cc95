"""What really happened, known only to the simulator and to the judge."""

from dataclasses import dataclass, field

from imubench.arrays import Array
from imubench.displays import Displayed, Summarised
from imubench.errors import unknown


@dataclass(frozen=True, repr=False)
class SegmentTruth(Summarised):
    """The motion of a segment frame, one row a sample."""

    name: str
    position: Array  # (n, 3) m, world
    quaternion: Array  # (n, 4) segment -> world
    velocity: Array  # (n, 3) m/s, world
    rate: Array  # (n, 3) rad/s, segment axes
    acceleration: Array  # (n, 3) m/s^2, world
    angular_acceleration: Array  # (n, 3) rad/s^2, segment axes


@dataclass(frozen=True, repr=False)
class SensorTruth(Summarised):
    """The motion of a sensor frame, what a perfect sensor there reads, and the joint as it sees it."""

    name: str
    position: Array  # (n, 3) m, world
    quaternion: Array  # (n, 4) sensor -> world
    acceleration: Array  # (n, 3) m/s^2, world
    gyro: Array  # (n, 3) rad/s, sensor axes
    specific_force: Array  # (n, 3) m/s^2, sensor axes
    angular_acceleration: Array  # (n, 3) rad/s^2, sensor axes
    joint_vector: Array  # (n, 3) m, r: from the sensor to the joint centre, sensor axes
    joint_axis: Array | None  # (n, 3) unit, the hinge axis in sensor axes; None without a hinge
    displacement: Array  # (n, 3) m, of the mount, segment axes; zero when rigid
    rotation: Array  # (n, 3) rad, rotation vector of the mount: q = q_mount exp(rotation)


@dataclass(frozen=True, repr=False)
class Truth(Summarised, Displayed):
    """Truth for every sample of a simulated experiment."""

    time: Array  # (n,) s, evenly spaced
    rig: str
    gravity: float  # m/s^2
    segments: tuple[SegmentTruth, ...]
    sensors: tuple[SensorTruth, ...]
    joint_angle: Array | None = None  # (n,) rad; None for a ball joint
    joint_rate: Array | None = None  # (n,) rad/s
    labels: tuple[tuple[str, float, float], ...] = field(default=())  # (what, start, end) s

    def sensor(self, name: str) -> SensorTruth:
        """Return the truth of one sensor; `InputError` names the known ones."""
        for sensor in self.sensors:
            if sensor.name == name:
                return sensor
        raise unknown("sensor", name, [s.name for s in self.sensors])
