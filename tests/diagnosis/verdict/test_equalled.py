"""What may be a finding without a name is told beside it."""

from dataclasses import replace

import pytest

from imubench.diagnosis.result import UNKNOWN, Finding, Interval, Rejected
from imubench.diagnosis.verdict.nameless_equivalents import with_equivalents, with_refused_equivalents


def said(effect, at, gain):
    return Finding(effect, at, 0.96, {}, Interval(gain, (gain, gain)))


def test_what_equals_a_name_equals_the_unknown_that_equals_it():
    axes, others = (Rejected("accel_misalignment", "imu2", 315.0), Rejected("gyro_misalignment", "imu1", 300.0))
    unknown = replace(said(UNKNOWN, "imu2", 315.0), equivalent=(axes,))
    named = replace(said("accel_misalignment", "imu2", 346.0), equivalent=(others,))
    (u,) = with_equivalents((unknown,), (named, replace(said("accel_bias", "imu2", 50.0), equivalent=(axes,))))
    assert u.equivalent == (axes, others)
    assert with_equivalents((said(UNKNOWN, "imu2", 315.0),), (named,))[0].equivalent == ()


@pytest.mark.parametrize(
    ("gain", "at", "equal"), [(70.0, "imu1", True), (50.0, "imu1", True), (40.0, "imu1", False), (70.0, "imu2", False)]
)
def test_what_was_refused_and_gained_as_much_equals_an_unknown_at_its_place(gain, at, equal):
    refused = Rejected("rocking_mount", at, gain)
    (u,) = with_refused_equivalents((said(UNKNOWN, "imu1", 53.0),), (), (refused,))
    assert u.equivalent == ((refused,) if equal else ())


def test_what_was_refused_for_a_loss_equals_nothing():
    (u,) = with_refused_equivalents((said(UNKNOWN, "imu1", -20.0),), (), (Rejected("soft_mount", "imu1", -22.0),))
    assert u.equivalent == ()


def test_a_name_that_is_found_is_no_equal():
    named, refused = said("gyro_scale", "imu1", 90.0), Rejected("gyro_scale", "imu1", 70.0)
    (u,) = with_refused_equivalents((said(UNKNOWN, "imu1", 53.0),), (named,), (refused,))
    assert u.equivalent == ()
