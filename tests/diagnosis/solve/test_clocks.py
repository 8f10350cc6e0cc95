"""Clocks before any fit, on recordings of the independent generator."""

import pytest

from imubench.diagnosis.solve.clock_offsets import late
from imubench.diagnosis.solve.initialize import model_of
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.mark.parametrize(
    ("rig", "at", "offset", "options"),
    [
        ("hinge", "imu2", -0.0371, {"base": "fixed", "encoder": True}),
        ("hinge", "imu2", 0.021, {"base": "free", "encoder": True}),
        ("hinge", "imu1", 0.021, {"base": "free", "encoder": True}),
        ("hinge", "imu2", 0.021, {"base": "free"}),
        ("free", "imu1", 0.012, {"pose": True}),
    ],
)
def test_a_clock_that_is_far_off_is_seen_before_the_fit(tmp_path, rig, at, offset, options):
    asked = [("time_offset", at, {"offset": offset})]
    make_case(tmp_path / "case", rig, effects=asked, seed=11, seconds=12.0, rate=100.0, **options)
    found = late(model_of(read(tmp_path / "case")[0]))
    assert found.pop(at) == pytest.approx(offset, abs=2.5e-3)
    assert all(abs(other) < 2.5e-3 for other in found.values())


def test_two_sensors_that_share_nothing_tell_nothing(tmp_path):
    make_case(tmp_path / "case", "hinge", effects=[], seed=12, seconds=8.0, rate=100.0, base="fixed")
    assert late(model_of(read(tmp_path / "case")[0])) == {"imu2": 0.0}
