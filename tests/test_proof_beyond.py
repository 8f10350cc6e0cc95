"""How far physics outside the table is from the nearest name, held against recordings that have both."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.proof.beyond import IMU, beyond, columns
from imubench.proof.bounds import visibility
from imubench.proof.case import build
from imubench.proof.options import Effect
from imubench.proof.played import played
from imubench.proof.sight import sight

SHORT = {"seconds": 6.0, "band": 2.0, "rate": 50.0}
CROSSED = {"from": 0, "to": 1, "share": 0.06}  # gyro y reads 6 % of gyro x: the first number of a misalignment


def crossed(delay):
    return build("hinge", [("cross_talk", "imu1", CROSSED | {"delay": delay})], 5, **SHORT)


def test_physics_that_a_name_is_has_nothing_beyond_it():
    case = crossed(0.001)
    found = beyond(case)
    assert visibility(case) > 10
    assert found["nearest"] == "gyro_misalignment at imu1"
    assert found["beyond"] < 0.02 * visibility(case)
    assert "gyro_misalignment at imu1" in found["same"]


@pytest.mark.slow
def test_a_delay_takes_cross_talk_away_from_a_misalignment():
    left = [beyond(crossed(delay))["beyond"] for delay in (0.01, 0.03, 0.1)]
    assert left == sorted(left)
    assert left[2] > 5 * left[0] > 0


def test_what_is_left_is_what_a_recording_with_the_name_taken_off_shows():
    """The best misalignment by search, put in with the other sign: the visibility of both together."""
    case = crossed(0.05)
    found, seen = beyond(case), sight(case)
    assert found["nearest"] == "gyro_misalignment at imu1"
    name = Effect("gyro_misalignment", "imu1", {"matrix": np.zeros(6)})
    plain = seen.readings([])
    C, d = columns(seen, plain, name), seen.readings(case.effects) - plain
    F = seen.information(np.column_stack([d, C]))
    off = replace(name, parameters={"matrix": -np.linalg.solve(F[1:, 1:], F[1:, 0])})
    both = replace(case, effects=[*case.effects, off])
    assert visibility(both, seen) == pytest.approx(found["beyond"], rel=0.02)


@pytest.mark.slow
def test_hysteresis_is_no_name():
    play = {"channel": "gyro", "share": 0.2, "width": 0.5}
    strange = build("hinge", [("hysteresis", "imu2", play)], 6, **SHORT)
    assert beyond(strange)["beyond"] > 0.5 * visibility(strange)
    assert beyond(strange)["same"] == []


@pytest.mark.slow
def test_a_mount_on_hardly_hardening_springs_is_one_on_straight_ones():
    springs = {"frequency": 12.0, "damping_ratio": 0.15}
    nearly, bent = (
        build("hinge", [("hardening_mount", "imu2", springs | {"span": span})], 7, **SHORT) for span in (0.03, 1e-3)
    )
    assert beyond(nearly)["nearest"] == "soft_mount at imu2"
    assert beyond(nearly)["beyond"] < 0.05 * visibility(nearly)
    assert beyond(bent)["beyond"] > 5 * beyond(nearly)["beyond"]


@pytest.mark.parametrize("rig", ["hinge", "pendulum", "free"])
@pytest.mark.parametrize("name", sorted(IMU))
def test_what_is_wrong_at_an_imu_leaves_the_motion_as_it_is(rig, name):
    """The readings of a rig that is played anew, and those on the motion that was played before it."""
    case = build(rig, [(name, "imu1", {k: np.asarray(v) + 0.01 for k, v in IMU[name].items()})], seed=3, seconds=3.0)
    seen = sight(case)
    again = played(seen.case.options, case.effects, case.seed)
    whole = np.concatenate([getattr(imu, channel).ravel() for imu in again.imus for channel in ("gyro", "accel")])
    stds = np.concatenate([np.full(part.S[0].shape[0] * 3, part.std) for part in seen.parts if "." in part.name])
    np.testing.assert_array_equal(seen.readings(case.effects)[: len(whole)], whole / stds)


def test_there_is_no_answer_where_the_motion_is_not_free():
    assert beyond(build("pendulum", [("wind", "joint")], 8, seconds=8.0, swing=True)) is None


def test_a_mount_that_slips_at_one_of_the_moments_is_a_slip():
    """Of moments 0.75 s apart one is at 3.375 s; the turn is so small that it is straight in its numbers."""
    slip = {"rotation": [0.002, -0.001, 0.003], "translation": [0.0, 0.001, 0.0], "time": 3.375}
    case = build("hinge", [("mount_shift", "imu2", slip)], 9, **SHORT)
    found = beyond(case)
    assert found["nearest"] == "mount_shift at imu2"
    assert found["beyond"] < 0.02 * visibility(case)


@pytest.mark.long
def test_what_is_slow_hides_in_noise_whose_colour_nobody_knows():
    """A jump of a bias in white noise: the least is what is left of it in noise of the slowest colour."""
    jump = {"channel": "gyro", "jump": [0.0, 0.002, 0.0], "time": 2.9}
    found = beyond(build("hinge", [("bias_jump", "imu1", jump)], 11, **SHORT))
    coloured = build("hinge", [("bias_jump", "imu1", jump)], 11, **SHORT, colour=0.2, corner=0.5)
    assert found["least"] == pytest.approx(beyond(coloured)["beyond"], rel=1e-6)
    assert found["least"] < 0.6 * found["beyond"]


def test_noise_of_a_known_colour_is_no_more_favourable_than_any():
    case = build("hinge", [("cross_talk", "imu1", CROSSED | {"delay": 0.05})], 5, **SHORT, colour=0.1)
    found = beyond(case)
    assert 0 < found["least"] <= found["beyond"]
