"""Sensors of two recordings are said not to move together."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.nonsense.different_motions import different_motions
from imubench.recording import Imu, Recording
from tests.diagnosis.nonsense.recordings import of_two, said


@pytest.mark.parametrize("seeds", [(1, 2), (2, 4), (5, 6), (7, 8)])
def test_two_unrelated_imus_do_not_move_together(made, seeds):
    pair = of_two(*(made("hinge", seed) for seed in seeds))
    assert said(different_motions(pair)) == ["the two IMUs do not move together"]


def test_a_pose_or_an_encoder_of_another_recording_does_not_go_with_the_imus(made):
    one, other = made("free", 1), made("free", 2)
    assert said(different_motions(replace(one, poses=other.poses))) == [
        "imu1 and the measured pose do not move together"
    ]
    one, other = made("encoder", 1), made("encoder", 2)
    found = said(different_motions(replace(one, encoders=other.encoders)))
    assert found == ["the IMUs and the encoder do not move together"]


def test_clocks_apart_by_less_than_a_diagnosis_looks_for_are_no_nonsense(made):
    recording = made("hinge", 1)
    one, two = recording.imus
    for late, expected in ((0.2, []), (3.0, ["the two IMUs do not move together"])):
        assert said(different_motions(replace(recording, imus=(one, replace(two, time=two.time + late))))) == expected


def test_a_rig_that_hardly_turns_across_its_hinge_is_not_judged(made):
    """Both IMUs turn about the hinge's axis alone, each as it likes: nothing is shared, and nothing must be."""
    time = np.arange(0, 20, 0.02)
    rng = np.random.default_rng(3)
    imus = []
    for name in ("imu1", "imu2"):
        rate = np.zeros((1000, 3))
        rate[:, 1] = np.convolve(rng.standard_normal(1000), np.ones(20) / 4, "same")
        force = np.tile([0.0, 0.0, 9.81], (1000, 1)) + 0.02 * rng.standard_normal((1000, 3))
        imus.append(Imu(name, time, rate + 0.002 * rng.standard_normal((1000, 3)), force, 50.0))
    assert list(different_motions(Recording("planar", "hinge", tuple(imus)))) == []
