"""Mirrored sensors are named with their axis."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.nonsense.handedness import SIGNED_PERMUTATIONS
from imubench.diagnosis.nonsense.mirrored import faults, mirrored
from imubench.recording import Imu, Recording
from tests.diagnosis.nonsense.recordings import I, changed, flip, said


def test_every_fault_belongs_to_the_way_that_it_makes():
    """f_r' = -S w_r x f_r follows from f' = -w x f for a random rate and force."""
    rng = np.random.default_rng(0)
    w, f = rng.standard_normal((2, 3))
    for fault in faults():
        ways = [m for m in SIGNED_PERMUTATIONS if fault.fits(m)]
        assert len(ways) == 1, fault.what
        w_r, f_r, slope = fault.gyro @ w, fault.accel @ f, fault.accel @ -np.cross(w, f)
        # rounding
        np.testing.assert_allclose(slope, -np.cross(ways[0] @ w_r, f_r), atol=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("rig", ["hinge", "pendulum", "free"])
def test_a_mirrored_sensor_is_named_with_its_axis(made, rig, axis):
    recording, at = made(rig, 1), made(rig, 1).imus[-1].name
    name, mirror = "xyz"[axis], flip(axis)
    both = f"{at} looks mirrored in {name}: gyr_{name} and acc_{name} have the wrong sign"
    assert said(mirrored(changed(recording, at, mirror, mirror))) == [both]
    gyro = f"{at}'s gyroscope looks mirrored in {name}: gyr_{name} has the wrong sign"
    assert said(mirrored(changed(recording, at, gyro=mirror))) == [gyro]
    accel = f"{at}'s accelerometer looks mirrored in {name}: acc_{name} has the wrong sign"
    assert said(mirrored(changed(recording, at, accel=mirror))) == [accel]


@pytest.mark.long
def test_axes_that_differ_between_gyroscope_and_accelerometer_are_said(made):
    turned = changed(made("hinge", 1), "imu2", gyro=I[[1, 2, 0]])
    (what,) = said(mirrored(turned))
    assert what == (
        "imu2's gyroscope and accelerometer have different axes: one reads (y, z, x) where the other has (x, y, z)"
    )
    swapped_axes = changed(made("hinge", 1), "imu2", I[[0, 2, 1]], I[[0, 2, 1]])
    assert said(mirrored(swapped_axes)) == ["imu2 looks mirrored: its y and z axes have changed places"]


@pytest.mark.long
def test_two_imus_mirrored_alike_are_both_named(made):
    mirror = flip(2)
    recording = changed(changed(made("hinge", 1), "imu1", mirror, mirror), "imu2", mirror, mirror)
    ends = "looks mirrored in z: gyr_z and acc_z have the wrong sign"
    assert said(mirrored(recording)) == [f"imu1 {ends}", f"imu2 {ends}"]


def test_where_no_mount_is_declared_the_mirrored_axis_is_left_open(made):
    mirror = flip(1)
    recording = changed(made("hinge", 1), "imu2", mirror, mirror)
    recording = replace(recording, imus=tuple(replace(i, mount_rotation_std=None) for i in recording.imus))
    assert said(mirrored(recording)) == [
        "imu2 looks mirrored: its axes are left-handed, or its gyroscope has the wrong sign"
    ]


def test_a_sensor_at_rest_is_not_called_mirrored(made):
    """Drift of less than the least velocity that counts, whatever its ratio."""
    time = np.arange(0, 20, 0.02)
    rng = np.random.default_rng(0)
    gyro = 0.002 * rng.standard_normal((1000, 3)) + 0.01
    accel = 0.02 * rng.standard_normal((1000, 3)) + [0.0, 0.0, 9.81]
    still = Imu("imu1", time, gyro, accel, 50.0)
    assert list(mirrored(Recording("still", "pendulum", (still,)))) == []
