"""A pelvis and a thigh that walk, and what an estimate of their joint's centre is off."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from imubench.scenarios.moving_pivot import (
    gait,
    hip_mounts,
    pelvis,
    shared_centre,
)
from imubench.scenarios.pendulum import ellipse
from imubench.sim.imu_model import observe
from imubench.sim.profiles import profile

IMU = profile("xsens_mtw_awinda")


def hip(seed, scale=1.0, motions=None, duration=10.0):
    """A pelvis that turns as in walking, the paper's limb on it, the hip moving: recording and truth."""
    rng = np.random.default_rng(seed)
    truth = shared_centre(motions or (pelvis(), ellipse()), hip_mounts(rng), gait(rng, scale=scale), duration)
    return observe(truth, IMU, rng), truth


def vectors(truth):
    return np.stack([s.joint_vector.mean(axis=0) for s in truth.sensors])


def errors(answer, truth, after=2.0):
    """Mean |dr| in m of both IMUs, from `after` s on."""
    return np.linalg.norm(answer.value[answer.time > after] - vectors(truth), axis=-1).mean(axis=0)


@dataclass(frozen=True)
class Later:
    """A signal that sets in smoothly at `start` s."""

    signal: Callable
    start: float

    def __call__(self, time):
        t = np.clip(time - self.start, 0.0, None)
        value, first, second = self.signal(t)
        left = np.exp(-(t**3))
        r, dr, ddr = 1 - left, 3 * t**2 * left, (6 * t - 9 * t**4) * left
        return r * value, dr * value + r * first, ddr * value + 2 * dr * first + r * second
