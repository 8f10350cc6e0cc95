"""Axes in another order, which is a mount that the search finds."""

import numpy as np
import pytest

from imubench.diagnosis.nonsense.permuted import permuted
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.recording import Imu
from imubench.rotations import conjugate, from_matrix, log, multiply
from tests.diagnosis.nonsense.recordings import I


def posed(at: str, turn, declared: Imu) -> Finding:
    rotation = Parameter(np.asarray(turn), np.full(3, 0.01), "rad")
    return Finding("mount_pose", at, 0.96, {"rotation": rotation}, Interval(100.0, (90.0, 110.0)))


@pytest.mark.parametrize("rig", ["hinge", "free"])
def test_a_mount_turned_by_an_order_of_axes_is_said_to_look_permuted(made, rig):
    recording = made(rig, 1)
    imu = recording.imus[-1]
    turn = log(from_matrix(I[[1, 2, 0]].T))  # the sensor reads (y, z, x): R' of what it should
    (found,) = permuted([posed(imu.name, turn, imu)], recording)
    assert found.what == f"{imu.name}'s axes look permuted: it reads (y, z, x) where the model has (x, y, z)"
    assert permuted([posed(imu.name, 0.5 * turn, imu)], recording) == ()
    assert permuted([posed(imu.name, [0.3, 0.1, -0.2], imu)], recording) == ()
    assert multiply(conjugate(imu.mount_quaternion), imu.mount_quaternion)[0] == pytest.approx(1.0)  # a unit
