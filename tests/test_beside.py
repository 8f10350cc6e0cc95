"""A name is doubted where something without a name at its place is worth much."""

import pytest

from imubench.diagnosis.result import UNKNOWN, Finding, Interval
from imubench.diagnosis.verdict import DOUBTFUL, beside


def said(effect, at, gain, confidence=0.98):
    return Finding(effect, at, confidence, {}, Interval(gain, (gain, gain)))


@pytest.mark.parametrize(
    ("at", "gain", "doubted"), [("imu1", 500.0, True), ("imu1", 50.0, False), ("imu2", 500.0, False)]
)
def test_a_name_is_doubted_beside_much_without_one(at, gain, doubted):
    (f,) = beside((said("accel_drift", "imu1", 1000.0),), (said(UNKNOWN, at, gain),))
    assert f.confidence == (DOUBTFUL if doubted else 0.98)


def test_a_doubt_makes_nothing_surer():
    (f,) = beside((said("accel_drift", "imu1", 10.0, 0.51),), (said(UNKNOWN, "imu1", 500.0),))
    assert f.confidence == 0.51
