"""A series without a name gives way to the spring or the filter whose series it is, and to no other."""

import pytest

from imubench.diagnosis.diagnose import diagnose
from imubench.format1 import read
from imubench.proof.case import make_case

SLOW = {"rate": 128.0, "rate2": 128.0, "encoder": True, "band": 1.725, "vigour": 0.874, "rest": 0.178}
QUIET = {"gyro_noise": 0.0037, "accel_noise": 0.0382, "misdeclared": 0.0955, "rotation_std": 0.033}


def found(folder, effect, parameters, seed=20261124):
    make_case(folder / "r", "hinge", [(effect, "imu1", parameters)], seed, seconds=15.0, **SLOW, **QUIET)
    return diagnose(read(folder / "r")[0])[0].findings


@pytest.mark.slow
def test_a_weak_spring_is_told_by_its_law(tmp_path):
    """It was an unknown that goes with how the sensor is pushed, a little later."""
    spring = {"frequency": [11.54, 13.31, 13.87], "damping_ratio": 0.114}
    assert [(f.effect, f.at) for f in found(tmp_path, "soft_mount", spring)] == [("soft_mount", "imu1")]


@pytest.mark.slow
def test_one_axis_that_reads_another_a_little_later_has_no_name(tmp_path):
    talk = {"from": 0, "to": 1, "share": 0.06, "delay": 0.04}
    assert [(f.effect, f.at) for f in found(tmp_path, "cross_talk", talk) if f.confidence > 0.6] == [
        ("unknown", "imu1")
    ]
