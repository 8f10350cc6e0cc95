"""A round of trials, on recordings of the independent generator."""

import numpy as np
import pytest

from imubench.diagnosis.nominal import nominal_fit
from imubench.diagnosis.rounds import attempted, dated
from imubench.diagnosis.select import candidates
from imubench.effects.mounts import LONGEST
from imubench.format1 import read
from imubench.proof.case import make_case

SLIP = {"rotation": [0.0, 0.15, 0.05], "translation": [0.004, 0.0, 0.0], "time": 5.3}


def test_all_that_a_round_tries_is_held_against_one_another_on_the_same_samples(tmp_path):
    """How a mount slips is not known: those samples are left out of what is beside it too, and of the fit without."""
    effects = [("mount_shift", "imu2", SLIP), ("gyro_bias", "imu1", {"bias": [0.03, -0.02, 0.02]})]
    make_case(tmp_path / "case", "hinge", effects, 71, seconds=10.0)
    fit = nominal_fit(read(tmp_path / "case")[0])
    some = [h for h in candidates(fit.model) if h.name in ("mount_shift@imu2", "gyro_bias@imu1", "accel_bias@imu2")]
    now = attempted(fit, some, lambda _: None)
    best = now.tried[0]
    assert best.hypothesis.name == "mount_shift@imu2"
    time = best.fit.state.values[best.hypothesis.key("time")][0] + fit.model.start
    assert time == pytest.approx(SLIP["time"], abs=LONGEST)
    assert len(now.tried) > 1
    for tried in (now.fit, now.first, *(t.fit for t in now.tried[1:])):
        masks = tried.model.masks or {}
        for sensor in ("imu1", "imu2"):
            stamps = fit.model.stamps[f"{sensor}.gyro"]
            left_out = stamps[~masks.get(f"{sensor}.gyro", np.ones(len(stamps), dtype=bool))]
            assert (len(left_out) > 0) == (sensor == "imu2")
            assert np.all(np.abs(left_out - time) < 1.5 * LONGEST)
    assert fit.model.masks is None  # what came in is as it was


def test_a_slip_needs_recording_before_and_after_it(tmp_path):
    make_case(tmp_path / "case", "hinge", [], 72, seconds=6.0)
    fit = nominal_fit(read(tmp_path / "case")[0])
    h = next(h for h in candidates(fit.model) if h.name == "mount_shift@imu1")

    def at(time):
        class Fitted:
            span = (0.0, 6.0)
            state = type("S", (), {"values": {h.key("time"): np.array([time])}})

        return dated(Fitted, h)

    assert at(3.0)
    assert not at(0.01)
    assert not at(5.99)
