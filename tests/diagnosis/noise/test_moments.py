"""Samples in the moment of a slip count as much as they tell, and again when there is no slip."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.noise.masking import mask_beside, weighed_beside, with_mask
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.result import Finding, Interval
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.solve.subset import excerpt
from imubench.diagnosis.verdict.believed import believed
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

SLIP = Hypothesis(EFFECTS["mount_shift"], "imu2")
NOISE = {"imu2.gyro": 0.002, "imu2.accel": 0.02}


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean") / "case"
    make_case(folder, "hinge", [], 77, seconds=5.0, rate=50.0)
    return nominal_fit(read(folder)[0])


def slipped(fit, turned):
    """Return a fit that holds a slip of so many rad at 2.5 s for true, solved to no more than that."""
    guess = {
        SLIP.key("rotation"): np.array([0.0, turned, 0.0]),
        SLIP.key("translation"): np.zeros(3),
        SLIP.key("time"): np.array([2.5]),
    }
    found = refit(fit, (SLIP,), guess, steps=0)
    return replace(found, noise=found.noise | NOISE)


def test_what_a_slip_hid_counts_again_when_it_is_gone(fit):
    left_out = with_mask(fit, mask_beside(slipped(fit, 0.1), SLIP))
    assert not all(mask.all() for mask in left_out.model.masks.values())
    back = weighed_beside(left_out, [], None)
    assert back.model.masks is None
    assert sum(len(r.time) for r in back.measured) == sum(len(r.time) for r in fit.measured)


def test_a_small_slip_leaves_its_moment_to_be_seen(fit):
    """Peak rates of the law: 0.0004 rad in 0.2 s turns by 15/8 * 0.0004 / 0.2 = 0.00375 rad/s."""
    seen = weighed_beside(slipped(fit, 0.0004), [SLIP], None)
    assert seen.model.masks is None
    times = seen.model.louder["imu2.gyro"]
    inside = times > 1
    assert 0.3 < inside.sum() / 50.0 < 0.6  # s, at 50 Hz: from half the longest course before to one after
    assert times[inside] == pytest.approx(np.hypot(1, 0.00375 / 0.002), rel=1e-3)
    (rows,) = (r for r in seen.measured if r.name == "imu2.gyro")
    assert rows.std.shape == (len(times), 3)


def test_a_large_slip_leaves_its_moment_out(fit):
    found = weighed_beside(slipped(fit, 0.1), [SLIP], None)
    assert found.model.louder is None
    assert (~found.model.masks["imu2.gyro"]).sum() > 10
    assert "imu1.gyro" not in found.model.masks


def test_samples_that_do_not_count_anyway_stay_out(fit):
    broken = {"imu1.accel": np.arange(len(fit.model.stamps["imu1.accel"])) > 4}
    found = weighed_beside(slipped(fit, 0.0004), [SLIP], broken)
    assert found.model.masks["imu1.accel"].tolist() == broken["imu1.accel"].tolist()


def test_nothing_is_solved_again_where_nothing_changes(fit):
    assert weighed_beside(fit, [], None) is fit
    seen = weighed_beside(slipped(fit, 0.0004), [SLIP], None)
    same = replace(seen, noise=slipped(fit, 0.0004).noise)
    assert weighed_beside(same, [SLIP], None).model.louder.keys() == seen.model.louder.keys()


def test_an_excerpt_takes_the_weights_along(fit):
    seen = weighed_beside(slipped(fit, 0.0004), [SLIP], None)
    short = excerpt(seen, 1.0, 4.0)
    (rows,) = (r for r in short.measured if r.name == "imu2.gyro")
    assert len(rows.std) == len(rows.time)
    assert rows.std.max() > rows.std.min()


@pytest.mark.parametrize(("confidence", "stays"), [(0.2, False), (0.6, True)])
def test_the_motion_that_is_told_is_of_what_is_believed(fit, confidence, stays):
    found = weighed_beside(slipped(fit, 0.1), [SLIP], None)
    told = believed(found, [Finding("mount_shift", "imu2", confidence, {}, Interval(9.0, (5.0, 13.0)))], None)
    assert [h.name for h in told.model.hypotheses] == ["mount_shift@imu2"] * stays
    assert (told.model.masks is None) != stays
    assert (told is found) == stays
