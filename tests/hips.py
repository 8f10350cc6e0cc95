"""A pelvis and a thigh that walk, and what an estimate of their joint's centre is off."""

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
