"""What a motion does not show of the joint's centre, and when the filter says so."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from imubench import rotations
from imubench.estimators import find
from imubench.estimators.two_imu_centre import estimate
from imubench.recording import Imu, Recording
from imubench.run import simulate
from imubench.scenarios.moving_pivot import (
    gait,
    hip_mounts,
    pelvis,
    shared_centre,
)
from imubench.scenarios.pendulum import R_TEXT, ellipse
from imubench.sim.imu_model import observe
from imubench.sim.signals import STILL, Sines
from tests.hips import IMU, errors, hip, vectors


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


def across(answer, truth):
    """The last error (6,) in m without its part along the hinge, which no hinge shows, and that part."""
    error = (answer.value[-1] - vectors(truth)).ravel()
    along = np.concatenate([s.joint_axis[0] for s in truth.sensors]) / np.sqrt(2)
    return error - along * (along @ error), along


def test_a_hinge_hides_one_direction_and_no_other():
    squares = []
    for seed in range(3):
        recording, truth = simulate("hinge-gait", seed)
        answer = find("two-imu-centre").estimate(recording)
        error, along = across(answer, truth)
        assert np.abs(error).max() < 0.002  # 0.5 mm measured
        hidden = np.sqrt(np.einsum("i,nij,j->n", along, answer.covariance, along))
        assert np.median(hidden) > 0.25  # as sure as before any sample: 0.3 m, but for a tenth of the time, 0.05
        assert abs(along @ answer.value[-1].ravel()) < 0.02  # nearest both sensors, as Seel 2012 has it
        values, vectors_ = np.linalg.eigh(answer.covariance[-1])
        squares += list((vectors_[:, :5].T @ error) ** 2 / values[:5])
    assert np.mean(squares) < 2.0  # a filter on a motion that is no random walk; 0.3 measured


def test_near_a_plane_it_is_less_sure():
    recording, truth = simulate("hinge-walking", 0)
    answer = estimate(recording)
    error, _ = across(answer, truth)
    assert np.linalg.norm(error) < 0.01
    assert np.sqrt(np.linalg.eigvalsh(answer.covariance[-1])[4]) > 3e-4


def test_a_pelvis_that_rests_shows_nothing_of_itself():
    recording, truth = hip(0, motions=(pelvis(scale=0.0), ellipse()))
    answer = estimate(recording)
    _, two = errors(answer, truth)
    assert two < 0.001
    assert np.sqrt(np.linalg.eigvalsh(answer.covariance[-1][:3, :3])[0]) > 0.25  # 0.3 m before any sample
    assert np.sqrt(np.linalg.eigvalsh(answer.covariance[-1][3:, 3:])[-1]) < 0.002


@pytest.mark.parametrize("noise", [(0.0, 0.0), (0.0017, 0.02)])
def test_motion_without_information_is_called_so(noise):
    rng = np.random.default_rng(4)
    time = np.arange(400) / 100
    imus = tuple(
        Imu(
            f"imu{i + 1}",
            time,
            noise[0] * rng.normal(size=(400, 3)),
            rotations.rotate_back(rotations.random(rng), np.tile([0, 0, 9.81], (400, 1)))
            + noise[1] * rng.normal(size=(400, 3)),
            100.0,
        )
        for i in range(2)
    )
    answer = estimate(Recording("still", "hinge", imus))
    assert answer.status == "not identifiable"
    assert answer.covariance is None


def test_a_locked_hinge_is_not_identified():
    assert estimate(simulate("hinge-locked", 0)[0]).status == "not identifiable"


def test_it_learns_later_what_a_motion_shows_later():
    """Six seconds in a plane, then out of it: r along the axis of flexion, unseen at first, is found."""
    flexion = Sines([0.35, 0.1], [0.95, 1.7])
    both = (
        replace(pelvis(), heading=STILL, tilt=STILL, spin=Sines(0.3, 0.8)),
        replace(ellipse(), heading=Later(Sines(0.3, 1.1), 6.0), tilt=Later(Sines(0.3, 0.9), 6.0), spin=flexion),
    )
    recording, _ = hip(0, motions=both, duration=14.0)
    answer = estimate(recording)
    row = np.searchsorted(answer.time, 5.9)
    assert answer.covariance[row, 4, 4] > 0.1**2  # r_2 along y, with the thigh's sensor unturned
    assert np.sqrt(answer.covariance[-1, 4, 4]) < 0.003
    assert np.linalg.norm(answer.value[-1, 1] - R_TEXT) < 0.003


def test_it_waits_while_both_segments_rest():
    rng = np.random.default_rng(7)
    mounts, centre = hip_mounts(rng), {k: Later(v, 3.0) for k, v in gait(rng).items()}
    turning = [
        replace(m, **{k: Later(getattr(m, k), 3.0) for k in ("heading", "tilt", "spin")}) for m in (pelvis(), ellipse())
    ]
    truth = shared_centre(tuple(turning), mounts, centre, 9.0)
    answer = estimate(observe(truth, IMU, rng))
    assert 3.0 < answer.time[0] < 4.0
    one, two = errors(answer, truth, after=6.0)
    assert one < 0.005  # 1.5 mm of 20 seeds at 6 s, 4 mm the worst
    assert two < 0.002
