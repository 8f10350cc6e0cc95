"""The paper's synthetic experiments: one motion, runs that differ in their noise, gravity taken out by name."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from imubench import rotations
from imubench.arrays import Array
from imubench.errors import unknown
from imubench.estimators.gravity import How, UkfSettings, linear_acceleration, remove_by_ukf
from imubench.recording import STANDARD_GRAVITY, Imu, Recording
from imubench.scenarios.pendulum import DURATION, R_TEXT, limb
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.profiles import profile
from imubench.sim.signals import Sines
from imubench.truth import SensorTruth, Truth

RATE = 100.0  # Hz
AHEAD = 90.0  # deg, of the turn about y on that about x: a quarter period makes an ellipse
TOLD = UkfSettings(tilt_std=0.001)  # rad, how well the unscented filter is told its first orientation
WAYS = {
    "known": "known",
    "told": "UKF, first orientation told",
    "late": "known, half a sample late",
    "vqf": "VQF, both ways in time",
    "ukf": "UKF, not told",
    "vqf-online": "VQF, as samples come",
}
"""Where the orientation is from that takes gravity out: `known` is the simulation's own, `late` sums up the turn rates
from the known first one, each over the step after it, UKF is the unscented filter of gravity.py."""


@dataclass(frozen=True)
class Runs:
    """What sensors on one pendulum read, and what is true of all of them."""

    time: Array  # (n,) s
    gyro: Array  # (runs, n, 3) rad/s
    accel: Array  # (runs, n, 3) m/s^2, specific force
    truth: SensorTruth

    @property
    def r(self) -> Array:
        """The true r (n, 3) in m."""
        return self.truth.joint_vector


@cache
def played(varying: bool, r: tuple[float, float, float] = tuple(R_TEXT), ahead: float = AHEAD) -> SensorTruth:
    """Return the truth of the sensor on the paper's pendulum, r (3,) in m constant or varying in the `paper` way."""
    return pendulum(varying, r, ahead).sensors[0]


@cache
def pendulum(varying: bool, r: tuple[float, float, float] = tuple(R_TEXT), ahead: float = AHEAD) -> Truth:
    """Return the truth of the paper's pendulum."""
    x, y, z = np.deg2rad([17.0, 9.0, 3.0])
    motion = AngleMotion(tilt=Sines(x, 1.0), spin=Sines(y, 1.0, np.deg2rad(ahead)), heading=Sines(z, 1 / 1.5))
    return play(limb("paper" if varying else "none", r), motion, DURATION, RATE)


def whole(varying: bool, seed: int) -> tuple[Recording, Truth]:
    """Return one run as a recording whose noise is declared, and what really happened."""
    truth = pendulum(varying)
    run = noisy(truth.sensors[0], [seed])
    stds = sensor_stds()
    imu = Imu("imu1", run.time, run.gyro[0], run.accel[0], RATE, gyro_noise_std=stds[0], accel_noise_std=stds[1])
    return Recording(f"{'varying' if varying else 'constant'}-{seed}", "pendulum", (imu,)), truth


def sensor_stds() -> tuple[float, float]:
    """Return the white noise of the paper's sensor per sample, rad/s and m/s^2."""
    sensor = profile("xsens_mtw_awinda")
    return sensor.gyro.sample_noise_std(RATE), sensor.accel.sample_noise_std(RATE)


def noisy(truth: SensorTruth, seeds: ArrayLike) -> Runs:
    """Return one run a seed, with the white noise of the paper's sensor."""
    stds = sensor_stds()
    n = truth.gyro.shape[0]
    noise = np.array([np.random.default_rng(int(s)).normal(size=(2, n, 3)) for s in np.atleast_1d(seeds)])
    time = np.arange(n) / RATE
    return Runs(time, truth.gyro + stds[0] * noise[:, 0], truth.specific_force + stds[1] * noise[:, 1], truth)


def removed(runs: Runs, way: str) -> Array:
    """Return the acceleration (runs, n, 3) in m/s^2, gravity taken out in one of `WAYS`."""
    first = runs.truth.quaternion[0]
    if way == "known":
        return runs.accel - _up(runs.truth.quaternion)
    if way == "told":
        return remove_by_ukf(runs.gyro, runs.accel, runs.time, settings=TOLD, first=first)
    if way == "late":
        return runs.accel - _up(_summed(runs.gyro, first))
    if way == "ukf":
        return remove_by_ukf(runs.gyro, runs.accel, runs.time)
    if way == "vqf":
        return _by_recordings(runs, "vqf")
    if way == "vqf-online":
        return _by_recordings(runs, "vqf-online")
    raise unknown("gravity removal", way, WAYS)


def _by_recordings(runs: Runs, how: How) -> Array:
    """Return the acceleration of each run by a way that takes a recording."""
    imus = (Imu("imu1", runs.time, w, f, RATE) for w, f in zip(runs.gyro, runs.accel, strict=True))
    return np.stack([linear_acceleration(Recording("run", "pendulum", (imu,)), how) for imu in imus])


def _summed(gyro: Array, first: Array) -> Array:
    """Return orientations (runs, n, 4), each turned from the one before by that one's rate over one step."""
    turns = rotations.exp(gyro / RATE)
    q = np.broadcast_to(first, (len(gyro), 4))
    answers = [q]
    for k in range(1, gyro.shape[1]):
        q = rotations.multiply(q, turns[:, k])
        answers.append(q)
    return np.stack(answers, axis=1)


def _up(q: Array) -> Array:
    return np.asarray(STANDARD_GRAVITY * rotations.to_matrix(q)[..., 2, :])
