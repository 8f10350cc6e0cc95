"""Signals that the IMU model reads, and profiles it reads them with."""

import numpy as np

from imubench.sim.imu_model import observe_imu
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.truth import SensorTruth, Truth

DENSE = 1000.0  # Hz
TONES = np.array([0.7, 1.9, 3.1])  # Hz, one an axis


def motion(time):
    """Return smooth gyro (rad/s) and specific force (m/s^2) at any times."""
    phase = 2 * np.pi * TONES * np.asarray(time)[:, None] + np.array([0.1, 1.2, 2.3])
    return 3.0 * np.sin(phase), 4.0 * np.cos(1.3 * phase) + np.array([0.0, 0.0, 9.81])


def sensor_truth(gyro, force, name="imu1"):
    zero, still = np.zeros_like(gyro), np.tile([1.0, 0, 0, 0], (len(gyro), 1))
    return SensorTruth(name, zero, still, zero, gyro, force, zero, zero, None, zero, zero)


def moving(seconds=4.0, dense=DENSE, start=0.0, names=("imu1", "imu2")):
    time = start + np.arange(round(seconds * dense) + 1) / dense
    gyro, force = motion(time)
    sensors = tuple(sensor_truth((k + 1) * gyro, force, name) for k, name in enumerate(names))
    return Truth(time, "hinge", 9.81, (), sensors)


def still(count, rate=100.0):
    """Return time and a sensor that reads nothing, at the IMU's own rate: what comes out is error."""
    return np.arange(count) / rate, sensor_truth(np.zeros((count, 3)), np.zeros((count, 3)))


def imu(gyro=None, accel=None, rate=DENSE, **sampling):
    return ImuProfile("test", rate, gyro or ChannelProfile(), accel or ChannelProfile(), **sampling)


def read(truth, profile, seed=0):
    return observe_imu(truth.sensor("imu1"), truth.time, profile, np.random.default_rng(seed))


def errors(channel, count, seed=0, rate=100.0):
    """Return the gyro of a still sensor (count, 3): its additive errors alone."""
    time, sensor = still(count, rate)
    return observe_imu(sensor, time, imu(channel, rate=rate), np.random.default_rng(seed)).gyro
