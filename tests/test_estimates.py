"""What estimators make of a recording with and without what was found: the same as the commands, finding by finding.

The recordings come from the generator in `proof/`: with one seed it makes one motion and one noise, whatever is in it.
"""

from dataclasses import replace

import numpy as np
import pytest

from imubench.answers import moved
from imubench.correction.corrected import corrected, lowest
from imubench.correction.estimates import estimates
from imubench.diagnosis.on_disk import estimates_as_dict
from imubench.diagnosis.result import Diagnosis, Doubt, FitQuality, Where
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.run import estimate
from tests.test_estimate_with import finding, saying, told

OFFSET = ("time_offset", "imu2", {"offset": 0.03})
BIAS = ("gyro_bias", "imu1", {"bias": [0.3, -0.2, 0.25]})


def made(folder, *effects, seconds=8.0):
    """A hinge in a hand with these effects, its reference, and its truth."""
    truth = make_case(folder, "hinge", list(effects), 5, seconds=seconds, name="case")
    return *read(folder), truth


def test_one_finding_moves_the_axis_by_what_the_command_says(tmp_path):
    """A late clock: no motion is fitted, so this is the estimators' time alone."""
    recording, reference, truth = made(tmp_path / "rec", OFFSET)
    said = saying(recording, *told(truth))
    axis, centre = estimates(recording, said, reference)
    without = corrected(recording, said).recording
    for one in (axis, centre):
        by, unit = moved(estimate(one.estimator, recording), estimate(one.estimator, without))
        assert one.unit == unit
        np.testing.assert_array_equal(one.moved, by)
        np.testing.assert_allclose(one.each[0], by, rtol=1e-9)  # it is all there is; the readings are rounded anew
    was, now = axis.off
    assert np.all(was > 1.0) and np.all(now < 0.3)  # deg: 0.03 s at 1 to 2 rad/s are 2 to 3 deg; without, the noise's
    assert centre.off is None  # no reference says where a sensor is
    written = estimates_as_dict((axis, centre))["estimates"]
    assert [e["unit"] for e in written] == ["deg", "mm"]
    assert written[0]["reference"] == {"as_it_came": was.tolist(), "without": now.tolist()}
    assert "reference" not in written[1]


@pytest.mark.long
def test_each_finding_is_left_in_alone(tmp_path):
    """What one of two does is what it does in a recording that has nothing else."""
    recording, _, truth = made(tmp_path / "both", OFFSET, BIAS)
    said = saying(recording, *told(truth), finding("unknown", "imu2", 0.9))
    axis, _ = estimates(recording, said)
    assert axis.each[2] is None  # what has no law stays in
    clean = estimate("olsson2020", made(tmp_path / "none")[0])
    for by, effect in zip(axis.each[:2], (OFFSET, BIAS), strict=True):
        alone = moved(clean, estimate("olsson2020", made(tmp_path / effect[0], effect)[0]))[0]
        # deg: the taken-out bias is the fit's to 1e-3 rad/s, and noise moves what two estimates differ by
        np.testing.assert_allclose(by, alone, rtol=0.1, atol=0.1)


def test_nothing_is_asked_where_nothing_can_be_taken_out(tmp_path):
    recording, _, truth = made(tmp_path / "rec", OFFSET, seconds=3.0)
    said, doubts = saying(recording, *told(truth)), (Doubt("it", "a reason"),)
    assert estimates(recording, replace(said, verdict="partly explained", doubts=doubts)) == ()
    assert estimates(recording, saying(recording, finding("time_offset", "imu2", 0.4, offset=0.03))) == ()
    assert estimates(recording, saying(recording, finding("unknown", "imu2"))) == ()


@pytest.mark.long
def test_a_pendulums_centre(tmp_path):
    make_case(
        tmp_path / "rec", "pendulum", [("accel_bias", "imu1", {"bias": [0.3, 0.2, -0.3]})], 5, name="case", seconds=8.0
    )
    recording, _ = read(tmp_path / "rec")
    (one,) = estimates(recording, saying(recording, finding("accel_bias", "imu1", bias=[0.3, 0.2, -0.3])))
    assert (one.estimator, one.unit, one.imus) == ("mrvs", "mm", ("imu1",))
    assert one.moved[0] > 1.0  # mm: 0.47 m/s^2 beside centripetal accelerations of some m/s^2 at 0.2 m


@pytest.mark.parametrize(
    ("bands", "hz"), [([(9.0, 20.0)], 9.0), ([(9.0, 20.0), (4.0, 6.0)], 4.0), ([(0.0, 20.0)], None), ([], None)]
)
def test_what_springs_leave_begins_at_the_lowest_of_their_bands_or_nowhere(bands, hz):
    where = tuple(Where("imu2", {"gyr_x": 1.0}, (band,), (), "", 1.0) for band in bands)
    said = replace(
        Diagnosis("rec", "hinge", "no mismatch", (1.0, 1.0), (), (), (), FitQuality((1.0, 1.0)), "", 1.0),
        where=(*where, Where("imu1", {"gyr_x": 1.0}, ((1.0, 2.0),), (), "", 1.0)),
    )
    assert lowest(said, {"imu2"}) == hz
