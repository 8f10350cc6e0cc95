"""Swapped files are named; another rig is not nonsense."""

from dataclasses import replace

import pytest

from imubench.diagnosis.nonsense import nonsense
from imubench.diagnosis.nonsense.swapped import reading, swapped
from tests.diagnosis.nonsense.recordings import said


@pytest.mark.parametrize("rig", ["hinge", "fixed"])
@pytest.mark.parametrize("seed", [1, 3, 4])
def test_swapped_files_are_named(made, rig, seed):
    """Not of seed 2, whose second mount is the first one turned half round the hinge: either order goes with it."""
    recording = made(rig, seed)
    one, two = recording.imus
    odd = replace(recording, imus=(reading(one, two), reading(two, one)))
    assert said(nonsense(odd)) == ["imu1 and imu2 look swapped: their files go with each other's mounts"]


def test_labels_swapped_with_their_mounts_are_another_rig_and_no_nonsense(made):
    one, two = made("hinge", 1).imus
    other = replace(made("hinge", 1), imus=(replace(two, name="imu1"), replace(one, name="imu2")))
    assert list(swapped(other)) == []
