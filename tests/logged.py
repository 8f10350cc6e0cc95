"""Runs by hand, and what a .rrd file holds of them."""

import numpy as np
from rerun.chunk import RrdReader

from imubench.estimate import Estimate
from imubench.recording import Imu, Recording
from imubench.rotations import exp, from_axis_angle, multiply, rotate, rotate_back
from imubench.truth import SegmentTruth, SensorTruth, Truth

G = np.array([0.0, 0.0, -9.81])
Y = np.array([0.0, 1.0, 0.0])
MOUNTS = {
    "imu1": ((-0.1, 0.0, 0.03), (0.3, -0.2, 0.5)),
    "imu2": ((0.1, 0.0, 0.03), (-0.6, 0.4, 0.1)),
}  # m, rotation vector


def rates(time, q):
    """Angular rate in the body's axes by central differences of the quaternions: enough for a picture."""
    inverse = q * [1, -1, -1, -1]
    w = 2 * multiply(inverse, np.gradient(q, time, axis=0))[:, 1:]
    return w


def hinge_truth(seconds=4.0, rate=200.0):
    """A hinge whose base tumbles about a fixed joint centre while the hinge swings."""
    t = np.arange(round(seconds * rate)) / rate
    angle = 0.3 + 0.8 * np.sin(2 * np.pi * 0.7 * t)
    turn = np.stack([0.5 * np.sin(1.9 * t), 0.4 * np.sin(1.3 * t), 0.6 * np.sin(0.8 * t)], axis=-1)
    q1 = exp(turn)
    q2 = multiply(q1, from_axis_angle(Y, angle))
    still = np.zeros((t.size, 3))
    centre = np.tile([0.2, 0.1, 0.4], (t.size, 1))
    segments, sensors = [], []
    for name, q in (("segment1", q1), ("segment2", q2)):
        w = rates(t, q)
        segments.append(SegmentTruth(name, centre, q, still, w, still, np.gradient(w, t, axis=0)))
        place, rotation = MOUNTS[name.replace("segment", "imu")]
        q_ws = multiply(q, exp(rotation))
        x = centre + rotate(q, place)
        a = np.gradient(np.gradient(x, t, axis=0), t, axis=0)
        gyro = rotate_back(exp(rotation), w)
        r = np.tile(rotate_back(exp(rotation), -np.array(place)), (t.size, 1))
        j = np.tile(rotate_back(exp(rotation), Y), (t.size, 1))
        sensors.append(
            SensorTruth(
                name.replace("segment", "imu"), x, q_ws, a, gyro, rotate_back(q_ws, a - G), still, r, j, still, still
            )
        )
    labels = (("slow", 0.0, seconds / 2), ("knock", seconds * 0.7, seconds * 0.75))
    return Truth(t, "hinge", 9.81, tuple(segments), tuple(sensors), angle, np.gradient(angle, t), labels)


def observed(truth, every=2, noise=0.01, seed=0):
    rng = np.random.default_rng(seed)
    imus = []
    for s in truth.sensors:
        shape = s.gyro[::every].shape
        place, rotation = MOUNTS[s.name]
        imus.append(
            Imu(
                s.name,
                truth.time[::every],
                s.gyro[::every] + noise * rng.normal(size=shape),
                s.specific_force[::every] + 5 * noise * rng.normal(size=shape),
                rate=1 / (every * (truth.time[1] - truth.time[0])),
                mount_position=place,
                mount_quaternion=exp(rotation),
            )
        )
    return Recording("swing-by-hand", "hinge", tuple(imus))


def axis_estimate(truth, off=(0.02, 0.15)):
    """The true axes, each turned by an angle in rad about a direction across it, and both signs turned."""
    value = []
    for sensor, angle in zip(truth.sensors, off, strict=True):
        j = sensor.joint_axis[0]
        across = np.cross(j, [0, 0, 1.0])
        value.append(-(np.cos(angle) * j + np.sin(angle) * across / np.linalg.norm(across)))
    return Estimate("joint_axis", "by-hand", np.array(value), np.eye(6) * 1e-4)


def pendulum_truth(seconds=4.0, rate=1000.0):
    """A pendulum that swings about x and y, with its sensor shaking in its mount."""
    t = np.arange(round(seconds * rate)) / rate
    q = exp(np.stack([0.5 * np.sin(3.1 * t), 0.7 * np.sin(2.7 * t), 0.2 * np.sin(t)], axis=-1))
    still = np.zeros((t.size, 3))
    w = rates(t, q)
    shake = np.stack([0.01 * np.sin(60 * t), 0 * t, 0 * t], axis=-1)
    place = np.array([0.06, -0.02, -0.2]) + shake
    x = rotate(q, place)
    a = np.gradient(np.gradient(x, t, axis=0), t, axis=0)
    segment = SegmentTruth("segment1", still, q, still, w, still, np.gradient(w, t, axis=0))
    sensor = SensorTruth("imu1", x, q, a, w, rotate_back(q, a - G), still, -place, None, shake, still)
    return Truth(t, "pendulum", 9.81, (segment,), (sensor,))


class Log:
    """What a .rrd file holds, by path and component."""

    def __init__(self, path):
        self.path = str(path)
        self.chunks = RrdReader(self.path).stream().collect()

    def read(self, path, component, index="sim_time"):
        """Return the times in whole ns (n,) and the values (n, ...) of one component."""
        table = self.chunks.reader(index=index, contents=path).to_pandas()
        name = next(c for c in table.columns if c.endswith(component))
        rows = table[table[name].notna()]
        values = np.array([np.array(v.tolist() if v.dtype == object else v) for v in rows[name]], dtype=object)
        return rows["sim_time"].astype("int64").to_numpy(), np.array(values.tolist())

    def static(self, path, component):
        return self.read(path, component, index=None)[1][0]

    def paths(self):
        table = self.chunks.reader(index="sim_time", contents="/**").to_pandas()
        return {c.split(":")[0] for c in table.columns}


def nanoseconds(time):
    return np.round(np.asarray(time) * 1e9).astype("int64")
