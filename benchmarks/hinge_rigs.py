"""Random hinge rigs in closed form: smooth angles, analytic derivatives, rigid-body kinematics in NumPy.

Independent of the project's simulator, so that neither can hide the other's mistakes.
"""

from dataclasses import dataclass, replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.recording import Imu, Recording

HINGE = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class HingeRig:
    """What two IMUs on a hinge read, and the true axes."""

    time: Array  # (n,) s
    gyro: Array  # (2, n, 3) rad/s
    accel: Array  # (2, n, 3) m/s^2
    axes: Array  # (2, 3) the hinge in each sensor's axes
    mounts: Array  # (2, 4) sensor -> segment
    vectors: Array  # (2, 3) m, from each sensor to the joint centre, sensor axes

    def noisy(self, rng: np.random.Generator, gyro_std: float, accel_std: float) -> "HingeRig":
        """Return the rig with white noise of these stds per sample added."""
        gyro = self.gyro + gyro_std * rng.normal(size=self.gyro.shape)
        return replace(self, gyro=gyro, accel=self.accel + accel_std * rng.normal(size=self.accel.shape))

    def recording(self) -> Recording:
        rate = 1.0 / float(self.time[1] - self.time[0])
        imus = (
            Imu(f"imu{i + 1}", self.time, self.gyro[i], self.accel[i], rate, mount_quaternion=self.mounts[i])
            for i in range(2)
        )
        return Recording("closed-form", "hinge", tuple(imus))


def _signals(rng: np.random.Generator, time: Array, count: int, amplitude: float) -> tuple[Array, Array, Array]:
    """Return sums of four sines (n, count) of 0.1 to 1 Hz, with first and second derivatives."""
    rate = 2 * np.pi * rng.uniform(0.1, 1.0, (4, count))
    phase = rng.uniform(0, 2 * np.pi, (4, count)) + rate * time[:, None, None]
    size = amplitude * rng.normal(size=(4, count)) / 2
    first = (size * rate * np.cos(phase)).sum(axis=1)
    return (size * np.sin(phase)).sum(axis=1), first, (-size * rate**2 * np.sin(phase)).sum(axis=1)


def random_rig(
    rng: np.random.Generator,
    count: int = 3000,
    rate: float = 100.0,
    lever: float = 0.1,
    amplitude: float = 1.0,
    planar: bool = False,
) -> HingeRig:
    """Return a noise-free rig: segment 1 turns by Rz(a) Rx(b) Ry(c), segment 2 by Ry(q) after it.

    `lever` is the std in m of the sensors' positions about the joint centre: at 0 the accelerometer
    constraint is exact. `planar`: both segments turn about the hinge only, tilted by 0.6 rad, and
    the constraint is exact again. `amplitude` scales segment 1's angles in rad.
    """
    time = np.arange(count) / rate
    angles, first, second = _signals(rng, time, 3, amplitude)
    if planar:
        angles[:, 0], angles[:, 1], first[:, :2], second[:, :2] = 0.0, 0.6, 0.0, 0.0
    (a, b, c), (da, db, dc), (dda, ddb, ddc) = angles.T, first.T, second.T
    sb, cb, sc, cc = np.sin(b), np.cos(b), np.sin(c), np.cos(c)
    w1 = np.stack([db * cc - da * cb * sc, dc + da * sb, db * sc + da * cb * cc], axis=1)
    dw1_x = ddb * cc - db * dc * sc - dda * cb * sc + da * db * sb * sc - da * dc * cb * cc
    dw1_z = ddb * sc + db * dc * cc + dda * cb * cc - da * db * sb * cc - da * dc * cb * sc
    dw1 = np.stack([dw1_x, ddc + dda * sb + da * db * cb, dw1_z], axis=1)
    turns = [
        rotations.from_axis_angle(axis, angle) for axis, angle in zip(np.eye(3)[[2, 0, 1]], (a, b, c), strict=True)
    ]
    q1 = rotations.multiply(rotations.multiply(turns[0], turns[1]), turns[2])
    hinge, d_hinge, dd_hinge = _signals(rng, time, 1, 1.5)
    relative = rotations.from_axis_angle(HINGE, hinge[:, 0])
    carried = rotations.rotate_back(relative, w1)
    w2 = carried + d_hinge * HINGE
    dw2 = rotations.rotate_back(relative, dw1) + np.cross(carried, d_hinge * HINGE) + dd_hinge * HINGE
    force = _signals(rng, time, 3, 0.2)[2] + np.array([0.0, 0.0, 9.81])  # of the joint centre, world
    mounts = rotations.random(rng, 2)
    gyro, accel, vectors = [], [], []
    motions = ((q1, w1, dw1), (rotations.multiply(q1, relative), w2, dw2))
    for mount, (q, w, dw) in zip(mounts, motions, strict=True):
        position = lever * rng.normal(size=3)
        f = rotations.rotate_back(q, force) + np.cross(dw, position) + np.cross(w, np.cross(w, position))
        gyro.append(rotations.rotate_back(mount, w))
        accel.append(rotations.rotate_back(mount, f))
        vectors.append(rotations.rotate_back(mount, -position))
    axes = rotations.rotate_back(mounts, HINGE)
    return HingeRig(time, np.stack(gyro), np.stack(accel), axes, mounts, np.stack(vectors))
