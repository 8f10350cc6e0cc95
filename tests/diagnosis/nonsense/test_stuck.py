"""Readings that never change: what of them is called stuck, and what is not."""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.nonsense.stuck import stuck
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.report.headline import headline
from tests.diagnosis.nonsense.recordings import held, said, with_imu


def test_a_stuck_triple_axis_or_imu_is_called_stuck(made):
    recording = made("hinge", 1)
    imu = recording.imus[1]
    every = [0, 1, 2]
    cases = {
        "imu2's gyroscope is stuck: it reads the same in every sample": {"gyro": held(imu.gyro, every)},
        "imu2's accelerometer is stuck: it reads the same in every sample": {"accel": held(imu.accel, every)},
        "gyr_z of imu2 is stuck: it reads the same in every sample": {"gyro": held(imu.gyro, [2])},
        "acc_x and acc_y of imu2 are stuck: they read the same in every sample": {"accel": held(imu.accel, [0, 1])},
        "imu2 is stuck: it reads the same in every sample, while the rig moves": {
            "gyro": held(imu.gyro, every),
            "accel": held(imu.accel, every),
        },
        "imu2's gyroscope is stuck: it reads the same for 75 % of the recording": {
            "gyro": held(imu.gyro, every, len(imu.time) // 4)
        },
    }
    for what, parts in cases.items():
        assert said(stuck(with_imu(recording, "imu2", **parts))) == [what]


def test_what_is_clipped_rounded_at_rest_or_clamped_is_not_called_stuck(made):
    recording = made("hinge", 1)
    one, two = recording.imus
    clipped = np.clip(two.accel, -1.0, 1.0)  # every axis at the same limit for most of the time
    assert list(stuck(with_imu(recording, "imu2", accel=clipped))) == []
    clipped = np.where(np.abs(two.accel) > 0, 2.0, two.accel)
    assert list(stuck(with_imu(recording, "imu2", accel=clipped, accel_range=2.0))) == []
    still = {"gyro": np.zeros_like(two.gyro), "accel": np.tile([0.0, 0.0, 9.8], (len(two.time), 1))}
    assert list(stuck(with_imu(made("fixed", 1), "imu1", **{k: v[: one.time.size] for k, v in still.items()}))) == []
    noise = np.random.default_rng(0).standard_normal(two.accel.shape)
    rounded = {"gyro": np.zeros_like(two.gyro), "accel": still["accel"] + 0.02 * noise}  # at rest, its gyro coarse
    assert list(stuck(with_imu(recording, "imu2", **rounded))) == []


def test_readings_that_never_change_anywhere_say_nothing(made):
    """All-zero samples with gravity = 0 were a trace of a singular matrix."""
    recording = made("hinge", 1)
    zero = replace(
        recording,
        gravity=0.0,
        imus=tuple(replace(i, gyro=0 * i.gyro, accel=0 * i.accel) for i in recording.imus),
    )
    found, _ = diagnose(zero)
    assert found.verdict == "unobservable"
    assert "imu1 reads the same in every sample: it is stuck, or nothing moves" in headline(found)
    assert not found.findings
