"""A start that is rougher than the first guess is not held too smooth: its quaternions keep their norm."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imubench.diagnosis.noise.nominal import START_NOISE, roughness
from imubench.diagnosis.problem.motion_prior import START_SMOOTH
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE
from imubench.diagnosis.solve.initialize import blind_start, model_of
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.recording import Imu, Pose, Recording

RATE, SECONDS = 200.0, 6.0


def turned(time, pace):
    angles = [[0.5, 0.9, 0.1], [0.3, 2.1, 1.0], [0.4, 3.0, 2.0]]
    return Rotation.from_euler(
        "zyx", np.stack([a * np.sin(2 * np.pi * pace * f * time + p) for a, f, p in angles], axis=1)
    )


def started(pace):
    """A free body without noise that turns `pace` times as often as up to 3 Hz, at its start."""
    time, h = np.arange(0, SECONDS, 1 / RATE), 1e-4
    rate = (turned(time - h, pace).inv() * turned(time + h, pace)).as_rotvec() / (2 * h)
    force = turned(time, pace).inv().apply(np.tile([0.0, 0.0, 9.81], (time.size, 1)))
    pose = Pose("segment1", time, np.zeros((time.size, 3)), turned(time, pace).as_quat(canonical=True)[:, [3, 0, 1, 2]])
    recording = Recording("r", "free", (Imu("imu1", time, rate, force, RATE, mount_rotation_std=0.01),), poses=(pose,))
    return blind_start(model_of(recording))


def test_a_calm_start_has_the_first_guess():
    model, state, anchor = started(0.2)
    assert roughness(model, state, anchor)[f"smooth.{ATTITUDE}"] == START_SMOOTH[ATTITUDE]


@pytest.mark.long
def test_a_quick_one_keeps_its_quaternions():
    model, state, anchor = started(3.0)
    guess = roughness(model, state, anchor)
    assert guess[f"smooth.{ATTITUDE}"] > 10 * START_SMOOTH[ATTITUDE]
    assert shortest(model, state, anchor, guess) > 0.8  # its norm is held to a tenth
    assert shortest(model, state, anchor, {name: START_SMOOTH[name.removeprefix("smooth.")] for name in guess}) < 0.6


def shortest(model, state, anchor, guess):
    """The smallest norm of the attitude's quaternion, splines beyond the samples left out, after a fit."""
    noise = {r.name: START_NOISE[r.name.split(".")[1]] for r in model.measured(state)}
    fit = solve(model, state, noise | guess, anchor, enough=1e-3)
    return np.linalg.norm(fit.state.coefficients[20:-20, model.tracks.columns(ATTITUDE)], axis=1).min()
