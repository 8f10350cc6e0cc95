"""A name is doubted where something without a name at its place is worth much."""

import numpy as np
import pytest

from imubench.diagnosis.hypothesis import Hypothesis
from imubench.diagnosis.result import UNKNOWN, Finding, Interval, Parameter
from imubench.diagnosis.samples import Sampled
from imubench.diagnosis.verdict import DOUBTFUL, STRANGE, beside, beside_rounding, verdict_of, with_samples
from imubench.effects import EFFECTS
from imubench.recording import Imu, Recording


def said(effect, at, gain, confidence=0.98):
    return Finding(effect, at, confidence, {}, Interval(gain, (gain, gain)))


@pytest.mark.parametrize(
    ("at", "gain", "doubted"),
    [("imu1", 500.0, True), ("imu1", 50.0, False), ("imu2", 500.0, False), ("imu2", 2000.0, True)],
)
def test_a_name_is_doubted_beside_much_without_one(at, gain, doubted):
    (f,) = beside((said("accel_drift", "imu1", 1000.0),), (said(UNKNOWN, at, gain),))
    assert f.confidence == (STRANGE if doubted else 0.98)


def test_a_doubt_makes_nothing_surer():
    (f,) = beside((said("accel_bias", "imu1", 10.0, 0.51),), (), [Hypothesis(EFFECTS["accel_bias"], "imu1")])
    assert f.confidence == 0.51


def test_names_that_are_all_but_refuted_explain_nothing():
    rest = (said(UNKNOWN, "imu1", 500.0),)
    assert verdict_of((said("accel_drift", "imu1", 10.0, STRANGE),), rest) == "unexplained"
    assert verdict_of((said("accel_drift", "imu1", 10.0, DOUBTFUL),), rest) == "partly explained"


@pytest.mark.parametrize(("gain", "doubted"), [(500.0, True), (50.0, False)])
def test_a_state_without_a_law_is_doubted_wherever_something_without_a_name_is(gain, doubted):
    (f,) = beside((said("moving_pivot", "joint", 1000.0),), (said(UNKNOWN, "imu1", gain),))
    assert f.confidence == (STRANGE if doubted else 0.98)


def test_a_name_that_a_term_equals_is_doubted():
    (f,) = beside((said("accel_bias", "imu1", 1000.0),), (), [Hypothesis(EFFECTS["accel_bias"], "imu1")])
    assert f.confidence == DOUBTFUL


@pytest.mark.parametrize(("at", "sure"), [("joint", DOUBTFUL), ("imu1", 0.9)])
def test_a_hum_is_doubted_beside_a_torque_without_a_name(at, sure):
    heard = Sampled((said("vibration", "imu2", 0.0, 0.9), said("dropouts", "imu2", 0.0, 0.99)), {})
    found = with_samples((), heard, (said(UNKNOWN, at, 500.0),))
    assert [f.confidence for f in found] == [sure, 0.99]


def test_what_is_there_whatever_else_is_is_not_doubted():
    bias = said("gyro_bias", "imu1", 10.0)
    (f,) = beside((bias,), (said(UNKNOWN, "imu1", 1000.0),), certain=("gyro_bias",))
    assert f.confidence == bias.confidence
    (f,) = beside((bias,), (said(UNKNOWN, "imu1", 1000.0),))
    assert f.confidence < bias.confidence


@pytest.mark.parametrize(
    ("effect", "at", "gain", "sure"),
    [
        ("soft_mount", "imu1", 228.0, DOUBTFUL),  # of 1,800 numbers up to 900 nat may be rounding's
        ("soft_mount", "imu1", 20000.0, 0.98),
        ("soft_mount", "imu2", 228.0, 0.98),
        ("accel_scale", "imu1", 228.0, 0.98),
    ],
)
def test_springs_worth_no_more_than_rounding_may_give_are_doubted(effect, at, gain, sure):
    time = np.arange(600) / 100.0
    imus = tuple(Imu(name, time, np.zeros((600, 3)), np.zeros((600, 3)), 100.0) for name in ("imu1", "imu2"))
    rounded = Finding("quantisation", "imu1", 0.99, {"step": Parameter(0.6, 0.001, "m/s^2")}, Interval(0.0, (0.0, 0.0)))
    found, same = beside_rounding((said(effect, at, gain), rounded), Recording("r", "hinge", imus))
    assert (found.confidence, same) == (sure, rounded)
