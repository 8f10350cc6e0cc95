"""Knocks of a joint with play, told from those of something that strikes the sensor."""

import numpy as np
import pytest

from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.verdict.play_impacts import impacts_of_play
from imubench.format1 import read
from imubench.proof.case import make_case

HAND = {"band": 1.0, "vigour": 0.87, "rest": 0.31, "gyro_noise": 0.0058, "accel_noise": 0.023, "rate2": 100.0}
TIMES = [2.1, 4.6, 6.1, 8.4, 10.8]


def said(folder, rig, effect, seed):
    """The recording and the knocks that its samples show."""
    make_case(folder / "r", rig, [effect], seed, seconds=15.0, **HAND)
    recording = read(folder / "r")[0]
    (found,) = check_samples(recording).findings
    assert (found.effect, found.at, found.confidence) == ("impacts", effect[1] if rig == "pendulum" else "imu2", 0.95)
    return recording, found


def play(width, direction):
    return ("joint_play", "joint", {"range": width, "direction": direction, "kind": "free"})


@pytest.mark.parametrize(("width", "direction", "seed"), [(0.002, 1.2, 11), (0.001, 0.3, 13), (0.004, 2.4, 11)])
def test_a_limb_that_falls_over_to_the_other_side_of_its_play_is_named(tmp_path, width, direction, seed):
    recording, knocks = said(tmp_path, "hinge", play(width, direction), seed)
    (found,) = impacts_of_play([knocks], recording)
    assert (found.effect, found.at) == ("joint_play", "joint")
    assert [(r.effect, r.at) for r in found.equivalent] == [("impacts", "imu2")]
    assert found.confidence < 0.7


def test_of_two_knocks_play_is_an_equal(tmp_path):
    recording, knocks = said(tmp_path, "hinge", play(0.002, 2.4), 13)
    assert knocks.parameters["times"].value.size == 2
    (found,) = impacts_of_play([knocks], recording)
    assert (found.effect, found.at) == ("impacts", "imu2")
    assert [(r.effect, r.at) for r in found.equivalent] == [("joint_play", "joint")]
    assert found.confidence < 0.7


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_strikes_a_sensor_from_anywhere_stays(tmp_path, seed):
    recording, knocks = said(tmp_path, "hinge", ("impacts", "imu2", {"times": TIMES, "peak": 2.0}), seed)
    assert impacts_of_play([knocks], recording) == (knocks,)


def test_a_pendulum_has_no_hinge_that_could_have_play(tmp_path):
    recording, knocks = said(tmp_path, "pendulum", ("impacts", "imu1", {"times": TIMES, "peak": 2.0}), 1)
    assert impacts_of_play([knocks], recording) == (knocks,)
    assert np.all(np.diff(knocks.parameters["times"].value) > 1.0)
