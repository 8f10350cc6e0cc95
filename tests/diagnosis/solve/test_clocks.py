"""Clocks before any fit, on recordings of the independent generator."""

import pytest

from imubench.diagnosis.config.solve import START
from imubench.diagnosis.problem.bspline import SUPPORT
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


@pytest.mark.parametrize("offset", [-0.1, 0.0, 0.1])
def test_knots_reach_as_far_as_the_clocks_lead_and_hardly_further(tmp_path, offset):
    asked = [("time_offset", "imu2", {"offset": offset})] if offset else []
    make_case(tmp_path / "case", "hinge", effects=asked, seed=11, seconds=12.0, rate=100.0, base="free", encoder=True)
    recording = read(tmp_path / "case")[0]
    model, stamps = model_of(recording), recording.imus[1].time
    knots = model.tracks.knots
    first, last = (float(t) - model.start for t in (min(0.0, -offset) + stamps[0], max(0.0, -offset) + stamps[-1]))
    least, most = (
        START.edge_s - 0.01,
        START.edge_s + 3 * knots.step,
    )  # the offset is known to 2.5 ms, stamps are 10 ms apart
    assert least < first - knots.start < most
    assert least < knots.start + knots.step * (knots.count - SUPPORT + 1) - last < most


def test_two_sensors_that_share_nothing_tell_nothing(tmp_path):
    make_case(tmp_path / "case", "hinge", effects=[], seed=12, seconds=8.0, rate=100.0, base="fixed")
    assert late(model_of(read(tmp_path / "case")[0])) == {"imu2": 0.0}
