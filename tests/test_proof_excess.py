"""What concealed effects add to the channels: against changes known in closed form, and what a motion hides."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.proof.case import build
from imubench.proof.excess import MARGIN, NOT_ASKED, excess
from imubench.proof.resumed import resumed

SHORT = {"seconds": 10.0, "rest": 0.0}
BIAS = {"bias": [0.0, 0.02, -0.01]}


def test_a_bias_adds_itself_and_in_a_swing_no_motion_hides_it():
    case = build("hinge", [("gyro_bias", "imu2", BIAS)], seed=4, swing=True, base="fixed", **SHORT)
    found = excess(case)
    assert set(found) == {
        f"{imu}.{kind}_{axis}" for imu in ("imu1", "imu2") for kind in ("gyr", "acc") for axis in "xyz"
    }
    assert [found[f"imu2.gyr_{axis}"].concealed for axis in "xyz"] == pytest.approx([0.0, 0.02, 0.01], abs=1e-12)
    assert found["imu2.gyr_y"].left == pytest.approx(0.02, rel=0.02)  # a turned mount changes rates by 2 % of them
    assert found["imu1.gyr_y"].concealed == 0.0


def test_what_a_hand_can_do_a_bias_shows_less_at_its_sensor_and_some_at_the_other():
    """Two gyroscopes of one free hinge: the motion shares the difference of their rates between them."""
    found = excess(build("hinge", [("gyro_bias", "imu2", BIAS)], seed=4, **SHORT))
    own, other = (np.sqrt(sum(found[f"{imu}.gyr_{k}"].left ** 2 for k in "xyz")) for imu in ("imu2", "imu1"))
    told = np.sqrt(sum(found[f"imu2.gyr_{k}"].concealed ** 2 for k in "xyz"))
    assert told == pytest.approx(np.hypot(0.02, 0.01), rel=1e-9)
    assert own < 0.75 * told  # equally good gyroscopes share it by halves; about the hinge the motion takes all
    assert own == pytest.approx(other, rel=0.1)


def test_a_turn_about_the_hinge_is_the_motions_own():
    """Skin that turns by a share of the hinge angle about the hinge is another angle: next to nothing is left of it."""
    case = build("hinge", [], seed=4, **SHORT)
    R = case.mounts[0].rotation
    about, across = (
        excess(build("hinge", [("skin_sliding", "imu1", {"slide": [0.0] * 3, "twist": 0.002 * R[k]})], seed=4, **SHORT))
        for k in (1, 0)
    )
    parts = [sum(x.left**2 / x.noise**2 for x in found.values()) for found in (about, across)]
    assert parts[0] < 0.01 * parts[1]  # the sensor's arm does not turn with it, which its accelerometer shows a little


@pytest.mark.parametrize("name", [n for n in NOT_ASKED if n != "thermal_walk"])
def test_what_has_no_mean_or_does_not_count_is_not_asked(name):
    assert excess(build("hinge", [(name, "imu2")], seed=2, **SHORT)) == {}
    beside = excess(build("hinge", [("gyro_bias", "imu2", BIAS), (name, "imu1")], seed=2, **SHORT))
    alone = excess(build("hinge", [("gyro_bias", "imu2", BIAS)], seed=2, **SHORT))
    concealed = [[x.concealed for x in found.values()] for found in (beside, alone)]
    assert concealed[0] == pytest.approx(concealed[1], abs=1e-9)  # without it, or with it on both sides


def test_coloured_noise_takes_nothing_up():
    """The colour of noise is no motion: a recording with some is off by as much."""
    white, coloured = (
        excess(build("hinge", [("gyro_bias", "imu2", BIAS)], seed=4, colour=c, **SHORT)) for c in (0.0, 0.2)
    )
    assert {n: x.left for n, x in white.items()} == {n: x.left for n, x in coloured.items()}


@pytest.mark.parametrize(("rig", "options"), [("hinge", {"base": "fixed"}), ("pendulum", {})])
def test_a_swing_that_goes_on_by_its_own_forces_is_the_swing(rig, options):
    case = build(rig, [("viscous_friction", "joint", {"c": 0.01})], seed=6, swing=True, **SHORT, **options)
    start, end = case.world.swings[0]
    cut = (start + end) / 2
    again = resumed(case.world, case.options, case.effects, case.seed, [(start, cut), (cut, end)])
    for old, new in zip(case.world.segments, again.segments, strict=True):
        assert np.abs(old.w - new.w).max() < 1e-8  # rad/s: the same equation from the same states
        assert np.abs(old.f - new.f).max() < 1e-6


@pytest.mark.parametrize(("rig", "options"), [("hinge", {"base": "fixed"}), ("pendulum", {})])
def test_without_its_friction_a_swing_keeps_its_energy_from_each_window_on(rig, options):
    case = build(rig, [("viscous_friction", "joint", {"c": 0.05})], seed=6, swing=True, **SHORT, **options)
    start, end = case.world.swings[0]
    cut = (start + end) / 2
    found = excess(case, [(start, cut), (cut, end)])
    whole = excess(case, [(start, end)])
    last = f"imu{len(case.imus)}"
    halves, one = (max(x.concealed / x.noise for n, x in of.items() if n.startswith(last)) for of in (found, whole))
    assert 20 < halves < one  # let go anew in the middle it is less far off
    samples = found[f"{last}.gyr_x"].samples
    assert samples == pytest.approx(100 * (end - start - 4 * MARGIN), abs=10)  # 100 Hz; rates are 0.3 % off


def test_options_of_noise_do_not_count():
    one = build("pendulum", [("gyro_bias", "imu1", BIAS)], seed=4, **SHORT)
    other = replace(one, options=replace(one.options, gaps=2, repeats=2))
    assert {n: x.left for n, x in excess(one).items()} == {n: x.left for n, x in excess(other).items()}
