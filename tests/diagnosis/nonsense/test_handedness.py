"""The ways in which a sensor's axes can be turned and mirrored, and the one that its readings go with."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.nonsense.handedness import SIGNED_PERMUTATIONS, handedness
from imubench.diagnosis.nonsense.stretch import grid, gridded
from tests.diagnosis.nonsense.recordings import I


def test_there_are_48_ways_and_the_first_changes_nothing():
    assert len(SIGNED_PERMUTATIONS) == 48
    assert np.array_equal(SIGNED_PERMUTATIONS[0], I)
    assert len({tuple(m.ravel()) for m in SIGNED_PERMUTATIONS}) == 48
    assert sum(np.linalg.det(m) > 0 for m in SIGNED_PERMUTATIONS) == 24


@pytest.mark.parametrize("way", range(0, 48, 5))
def test_the_way_that_a_gyroscope_is_turned_is_the_one_found(made, way):
    """The gyroscope reads the transpose of what the accelerometer's axes would have it read."""
    imu = made("pendulum", 1).imus[0]
    samples = gridded(imu, grid([imu.time]))
    found = handedness(replace(samples, gyro=samples.gyro @ SIGNED_PERMUTATIONS[way]))
    assert found.best == way
    assert found.wrong == (way != 0)
