"""A name is doubted where something without a name at its place is worth much."""

import numpy as np
import pytest

from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.result import UNKNOWN, Finding, Interval, Parameter, Where
from imubench.diagnosis.samples.screening import SampleChecks
from imubench.diagnosis.search.confidence import DOUBTFUL, STRANGE
from imubench.diagnosis.search.rounding import beside_rounding
from imubench.diagnosis.verdict.posterior import (
    doubted_beside_unknown,
    ranked_by_confidence,
    verdict_of,
    with_samples,
)
from imubench.effects import EFFECTS
from imubench.recording import Imu, Recording


def said(effect, at, gain, confidence=0.98, where=None):
    return Finding(effect, at, confidence, {}, Interval(gain, (gain, gain)), where=where)


@pytest.mark.parametrize(
    ("at", "gain", "sure"),
    [
        ("imu1", 500.0, STRANGE),
        ("imu1", 50.0, 0.98),
        ("imu2", 50.0, 0.98),
        ("imu2", 500.0, DOUBTFUL),
        ("imu2", 2000.0, STRANGE),
    ],
)
def test_a_name_is_doubted_beside_much_without_one(at, gain, sure):
    (f,) = doubted_beside_unknown((said("accel_drift", "imu1", 1000.0),), (said(UNKNOWN, at, gain),))
    assert f.confidence == sure


@pytest.mark.parametrize(
    ("effect", "sure"), [("mount_pose", DOUBTFUL), ("rocking_mount", DOUBTFUL), ("gyro_bias", 0.98)]
)
def test_a_mount_is_doubted_beside_a_spline_of_the_joint_that_is_worth_more(effect, sure):
    _, f = doubted_beside_unknown((said("moving_pivot", "joint", 31000.0), said(effect, "imu1", 175.0)), ())
    assert f.confidence == sure


@pytest.mark.parametrize(("joint", "gain", "sure"), [("joint_play", 30.0, STRANGE), ("joint_play", 50000.0, 0.98),
                                                     ("dry_friction", 30.0, 0.98)])  # fmt: skip
def test_a_sensor_that_slides_with_its_skin_is_not_believed_beside_a_joint_that_is_loose(joint, gain, sure):
    """Its twist goes with the joint's angle, as what a loose joint's spline follows does."""
    _, f = doubted_beside_unknown((said(joint, "joint", 40000.0), said("skin_sliding", "imu2", gain)), ())
    assert f.confidence == sure


@pytest.mark.parametrize(("at", "sure"), [("imu1", DOUBTFUL), ("imu2", 0.95)])
def test_a_name_is_doubted_beside_one_without_that_only_spares_the_motion(at, sure):
    """Of a gyroscope's walk on a free body: a drift of 643 nat, and what gained -166 on held-out data."""
    (f,) = doubted_beside_unknown((said("gyro_drift", "imu1", 643.0, 0.95),), (said(UNKNOWN, at, -166.0),))
    assert f.confidence == sure


def test_a_doubt_makes_nothing_surer():
    (f,) = doubted_beside_unknown(
        (said("accel_bias", "imu1", 10.0, 0.51),), (), [Hypothesis(EFFECTS["accel_bias"], "imu1")]
    )
    assert f.confidence == 0.51


def test_names_that_are_all_but_refuted_explain_nothing():
    rest = (said(UNKNOWN, "imu1", 500.0),)
    assert verdict_of((said("accel_drift", "imu1", 10.0, STRANGE),), rest) == "unexplained"
    assert verdict_of((said("accel_drift", "imu1", 10.0, DOUBTFUL),), rest) == "partly explained"


@pytest.mark.parametrize(("gain", "doubted"), [(500.0, True), (50.0, False)])
def test_a_state_without_a_law_is_doubted_wherever_something_without_a_name_is(gain, doubted):
    (f,) = doubted_beside_unknown((said("moving_pivot", "joint", 1000.0),), (said(UNKNOWN, "imu1", gain),))
    assert f.confidence == (STRANGE if doubted else 0.98)


def test_a_name_that_a_term_equals_is_doubted():
    (f,) = doubted_beside_unknown(
        (said("accel_bias", "imu1", 1000.0),), (), [Hypothesis(EFFECTS["accel_bias"], "imu1")]
    )
    assert f.confidence == DOUBTFUL


@pytest.mark.parametrize(("at", "sure"), [("joint", DOUBTFUL), ("imu2", DOUBTFUL), ("imu1", 0.9)])
def test_a_hum_is_doubted_beside_something_without_a_name(at, sure):
    heard = SampleChecks((said("vibration", "imu2", 0.0, 0.9), said("dropouts", "imu2", 0.0, 0.99)), {})
    found = with_samples((), heard, (said(UNKNOWN, at, 500.0),))
    assert [f.confidence for f in found] == [sure, 0.99]


def test_what_is_there_whatever_else_is_is_not_doubted():
    bias = said("gyro_bias", "imu1", 10.0)
    (f,) = doubted_beside_unknown((bias,), (said(UNKNOWN, "imu1", 1000.0),), certain=("gyro_bias",))
    assert f.confidence == bias.confidence
    (f,) = doubted_beside_unknown((bias,), (said(UNKNOWN, "imu1", 1000.0),))
    assert f.confidence < bias.confidence


@pytest.mark.parametrize(
    ("effect", "at", "gain", "std", "sure"),
    [
        ("soft_mount", "imu1", 228.0, 0.03, STRANGE),  # of 1,800 numbers up to 900 nat may be rounding's
        ("soft_mount", "imu1", 228.0, None, STRANGE),
        ("soft_mount", "imu1", 228.0, 0.15, DOUBTFUL),  # noise that blurs steps of 0.6 m/s^2
        ("soft_mount", "imu1", 20000.0, 0.03, 0.98),
        ("soft_mount", "imu2", 228.0, 0.03, 0.98),
        ("soft_mount", "imu2", -3.0, 0.03, 0.98),  # a tie in the place of an offset, say
        ("moving_pivot", "joint", 228.0, 0.03, 0.98),
        ("accel_scale", "imu1", 228.0, 0.03, 0.98),
        ("mount_shift", "imu1", -51.0, 0.03, STRANGE),  # told by its moment alone
        ("mount_shift", "imu1", 51.0, 0.03, 0.98),
        ("mount_shift", "imu2", -51.0, 0.03, 0.98),
    ],
)
def test_springs_and_slips_worth_no_more_than_rounding_may_give_are_doubted(effect, at, gain, std, sure):
    found, same = beside_rounding((said(effect, at, gain), ROUNDED), rounded_recording("hinge", ("imu1", "imu2"), std))
    assert (found.confidence, same) == (sure, ROUNDED)


def test_a_pivot_that_only_a_rounded_sensor_shows_is_doubted():
    alone = rounded_recording("pendulum", ("imu1",), 0.03)
    (found, _) = beside_rounding((said("moving_pivot", "joint", 228.0), ROUNDED), alone)
    assert found.confidence == STRANGE


@pytest.mark.parametrize(
    ("size", "heard", "sure"), [(0.1, (), STRANGE), (0.1, ("imu1",), 0.98), (0.1, ("imu2",), STRANGE), (0.3, (), 0.98)]
)
def test_a_hum_that_only_the_fit_has_is_doubted_where_rounding_may_hum_so(size, heard, sure):
    """A sawtooth of 0.6 m/s^2 has 0.19 at its own frequency, and less at any other."""
    hum = Finding(
        "vibration", "imu1", 0.98, {"amplitude": Parameter(np.array([0.0, size, 0.0]), np.ones(3), "m/s^2")},
        Interval(93.0, (51.0, 126.0)),
    )  # fmt: skip
    found, _ = beside_rounding((hum, ROUNDED), rounded_recording("hinge", ("imu1", "imu2"), 0.03), heard)
    assert found.confidence == sure


ROUNDED = Finding("quantisation", "imu1", 0.99, {"step": Parameter(0.6, 0.001, "m/s^2")}, Interval(0.0, (0.0, 0.0)))


def rounded_recording(rig, names, std):
    """IMUs of 600 samples whose accelerometers have white noise of `std`."""
    time, none = np.arange(600) / 100.0, np.zeros((600, 3))
    return Recording("r", rig, tuple(Imu(n, time, none, none, 100.0, accel_noise_std=std) for n in names))


@pytest.mark.parametrize(
    ("words", "channel", "sure"),
    [
        ("the reading of axis x, a little later", "gyr_y", DOUBTFUL),
        ("the reading of axis x, a little later", "acc_y", 0.98),
        ("shaking", "gyr_y", 0.98),
    ],
)
def test_a_misalignment_beside_what_its_axes_read_a_little_later_is_doubted(words, channel, sure):
    late = said(UNKNOWN, "imu1", 50.0, where=Where("imu1", {channel: 1.0}, (), (), words, 1.0))
    (f,) = doubted_beside_unknown((said("gyro_misalignment", "imu1", 4000.0),), (late,))
    assert f.confidence == sure


@pytest.mark.parametrize(("gain", "sure"), [(3000.0, DOUBTFUL), (20000.0, 0.98)])
def test_springs_beside_a_joint_s_spline_that_is_worth_more_are_doubted(gain, sure):
    play, springs = doubted_beside_unknown(
        (said("joint_play", "joint", 10000.0), said("rocking_mount", "imu2", gain)), ()
    )
    assert (play.confidence, springs.confidence) == (0.98, sure)


def test_what_is_doubted_stands_behind_what_is_sure_and_else_the_stronger_before():
    found = (
        said("moving_pivot", "joint", 800.0, 0.65),
        said("gyro_bias", "imu1", 300.0, 0.96),
        said("low_pass", "imu1", 100.0, 0.2),
        said("end_stop", "joint", 50.0, 0.96),
    )
    assert [f.effect for f in ranked_by_confidence(found)] == ["gyro_bias", "end_stop", "moving_pivot", "low_pass"]
