"""The paper's pendulum in NumPy alone: many runs that differ in their noise, derivatives by hand.

Independent of the simulator: Garcia de Villa et al., section IV-A, with R = Rz(heading) Rx(tilt) Ry(spin).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from imubench import rotations
from imubench.arrays import Array
from imubench.recording import Imu, Pose, Recording

RATE = 100.0  # Hz
GRAVITY = 9.81  # m/s^2
NOISE = 0.0017, 0.02  # rad/s, m/s^2, per sample
R_MEAN = np.array([-0.06, 0.02, 0.2])  # m
R_VARIES = np.array([0.02, 0.005, 0.02])  # m, at 1 Hz
X, Y, Z = np.eye(3)


@dataclass(frozen=True)
class Runs:
    """What `count` sensors on one pendulum read, and what is true."""

    time: Array  # (n,) s
    gyro: Array  # (count, n, 3) rad/s, sensor axes, with noise
    accel: Array  # (count, n, 3) m/s^2, specific force, with noise
    acceleration: Array  # (count, n, 3) m/s^2, gravity taken out by the true orientation, with noise
    rate: Array  # (n, 3) rad/s, true
    angular_acceleration: Array  # (n, 3) rad/s^2, true
    r: Array  # (n, 3) m, true
    quaternion: Array  # (n, 4) sensor -> world, true

    def recording(self, run: int = 0, pose: bool = False) -> Recording:
        """Return one run as a recording, on request with the true orientation as a pose sensor."""
        imu = Imu("imu1", self.time, self.gyro[run], self.accel[run], RATE, *NOISE)
        poses = (Pose("segment1", self.time, quaternion=self.quaternion),) if pose else ()
        return Recording("run", "pendulum", (imu,), poses=poses)


def circling(
    rng: np.random.Generator,
    count: int = 1,
    amplitude: ArrayLike = 0.0,
    noise: tuple[float, float] = NOISE,
    duration: float = 10.0,
    r: ArrayLike = R_MEAN,
) -> Runs:
    """Return runs on the paper's ellipse; r varies by `amplitude` (3,) m at 1 Hz, unfelt (the `paper` kind)."""
    time = np.arange(round(duration * RATE)) / RATE
    spin, tilt, heading = (
        _sine(time, np.deg2rad(degrees), hertz, phase)
        for degrees, hertz, phase in ((9.0, 1.0, np.pi / 2), (17.0, 1.0, 0.0), (3.0, 1 / 1.5, 0.0))
    )
    qx, qy = (rotations.from_axis_angle(axis, angle[0]) for axis, angle in ((X, tilt), (Y, spin)))
    q = rotations.multiply(rotations.multiply(rotations.from_axis_angle(Z, heading[0]), qx), qy)
    rate, angular = _rates(qx, qy, heading, tilt, spin)
    varying = np.asarray(r) + np.multiply.outer(np.sin(2 * np.pi * time), np.broadcast_to(amplitude, (3,)))
    acceleration = -np.cross(angular, varying) - np.cross(rate, np.cross(rate, varying))
    up = rotations.rotate_back(q, np.broadcast_to(GRAVITY * Z, acceleration.shape))
    shape = (count, *rate.shape)
    felt = acceleration + noise[1] * rng.normal(size=shape)
    gyro = rate + noise[0] * rng.normal(size=shape)
    return Runs(time, gyro, felt + up, felt, rate, angular, varying, q)


def _sine(time: Array, amplitude: float, hertz: float, phase: float) -> tuple[Array, Array, Array]:
    w = 2 * np.pi * hertz
    sine, cosine = np.sin(w * time + phase), np.cos(w * time + phase)
    return amplitude * sine, amplitude * w * cosine, -amplitude * w**2 * sine


def _rates(
    qx: Array, qy: Array, heading: tuple[Array, ...], tilt: tuple[Array, ...], spin: tuple[Array, ...]
) -> tuple[Array, Array]:
    """Return angular rate and acceleration (n, 3) in sensor axes, passing one axis after the other down the chain.

    A frame that turns by angle a about its own unit vector e in a parent with rate v has w = R^T v + a' e and
    w' = R^T v' + a'' e - a' e x R^T v.
    """
    rate = np.multiply.outer(heading[1], Z)
    angular = np.multiply.outer(heading[2], Z)
    for q, axis, (_, first, second) in ((qx, X, tilt), (qy, Y, spin)):
        carried, own = rotations.rotate_back(q, rate), np.multiply.outer(first, axis)
        angular = rotations.rotate_back(q, angular) + np.multiply.outer(second, axis) - np.cross(own, carried)
        rate = carried + own
    return rate, angular
