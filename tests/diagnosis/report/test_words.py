"""Sentences about a finding."""

import numpy as np
import pytest

from imubench.diagnosis.report.words import whose_axes
from imubench.diagnosis.result import Finding, Interval, Parameter


@pytest.mark.parametrize(
    ("effect", "at", "names", "said"),
    [
        ("gyro_bias", "imu1", ("bias",), "x, y and z are axes of imu1."),
        (
            "mount_pose",
            "imu2",
            ("rotation", "translation"),
            "x, y and z are axes of imu2 for the rotation and of its segment for the translation.",
        ),
        ("moving_centre", "joint", ("slide",), "x, y and z are axes of the segment."),
        ("time_offset", "imu1", ("offset",), ""),
        ("unknown", "imu1", (), ""),
    ],
)
def test_whose_axes_numbers_are_of_is_said(effect, at, names, said):
    numbers = {name: Parameter(np.zeros(3), np.ones(3), "1") for name in names}
    assert whose_axes(Finding(effect, at, 0.9, numbers, Interval(0.0, (0.0, 0.0)))) == said
