"""The judge of real recordings, itself judged by the truth of simulated ones."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.reference import Reference
from imubench.reference_axes import reference_axes
from imubench.rotations import angle_between
from imubench.run import reference_of, simulate


@pytest.mark.parametrize("seed", range(3))
def test_axes_from_the_reference_are_the_true_ones(seed):
    recording, truth = simulate("hinge-hand", seed)
    axes = reference_axes(recording, reference_of(truth, recording))
    true = [s.joint_axis[0] for s in truth.sensors]
    # Gyro noise of 0.004 rad/s against rates of 2 rad/s over 3000 samples: 0.003 deg; the 0.5 deg/s bias adds 0.1.
    assert np.rad2deg(angle_between(axes, true)).max() < 0.2


def test_frames_that_were_not_seen_do_no_harm():
    recording, truth = simulate("hinge-hand", 0)
    full = reference_of(truth, recording)
    holes = full.quaternion1.copy()
    holes[100:400] = np.nan
    axes = reference_axes(recording, replace(full, quaternion1=holes))
    assert np.rad2deg(angle_between(axes, [s.joint_axis[0] for s in truth.sensors])).max() < 0.3


def test_a_reference_that_cannot_tell_gives_none():
    recording, truth = simulate("hinge-planar", 0)
    reference = reference_of(truth, recording)
    assert reference_axes(recording, reference) is None  # everything turns about one direction
    assert reference_axes(recording, None) is None
    assert reference_axes(recording, Reference(reference.time, hinge_angle=reference.hinge_angle)) is None
