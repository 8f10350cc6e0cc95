"""BROAD, the Berlin robust orientation estimation assessment dataset: one IMU and its optical pose.

Source: Laidig et al., "BROAD: a benchmark for robust inertial orientation estimation", Data 2021, CC BY 4.0.
"""

from pathlib import Path

import numpy as np

from imubench.alignment import check_z_up, gyro_delay
from imubench.arrays import Array
from imubench.convert.converter import Converted, Converter, Option, number
from imubench.errors import InputError
from imubench.inputs.hdf5 import read_hdf5
from imubench.recording import Imu, Pose, Recording
from imubench.timing import on_imu_clock

WIDTHS = {"imu_acc": 3, "imu_gyr": 3, "opt_quat": 4, "opt_pos": 3}


def convert(source: Path, optical_delay: float | None = None) -> list[Converted]:
    """Return one trial: the IMU on a free body whose optical pose, east-north-up, is a sensor.

    `source` is one of the dataset's .hdf5 files. The segment frame is the dataset's: turned as the IMU (to
    a fraction of a degree), with its origin in the optical body, whose place against the IMU is not known. The pose's
    stamps are those of the IMU's clock: k / rate less the delay that the gyroscope shows (`optical_timing`), or the
    given one.
    """
    arrays, rate, moving = _read(source)
    time = np.arange(len(arrays["imu_gyr"])) / rate
    imu = Imu(
        name="imu1", time=time, gyro=arrays["imu_gyr"], accel=arrays["imu_acc"], rate=rate, mount_rotation_std=0.01
    )
    quaternion = arrays["opt_quat"] / np.linalg.norm(arrays["opt_quat"], axis=-1, keepdims=True)
    stamps, timed = on_imu_clock([(imu, time, quaternion)], time, optical_delay)
    tilt = check_z_up(imu, stamps, quaternion)
    delay, misfit = gyro_delay(imu, stamps, quaternion)
    unseen = int(np.isnan(quaternion).any(axis=-1).sum())
    note = (
        f"BROAD trial {source.stem}, Laidig et al. 2021, CC BY 4.0. World east-north-up; optical orientation unseen in "
        f"{unseen} of {time.size} samples; IMU position against the optical body unknown. Movement phase {moving}. "
        f"{timed} Specific force {np.rad2deg(tilt):.1f} deg from the optical z on average; gyroscope "
        f"{delay * 1e3:+.1f} ms late against the pose, |rate| misfit {np.rad2deg(misfit):.1f} deg/s RMS."
    )
    pose = Pose(segment="segment1", time=stamps, position=arrays["opt_pos"], quaternion=quaternion)
    recording = Recording(name=f"broad-{source.stem}", rig="free", imus=(imu,), poses=(pose,))
    return [Converted(recording, None, note)]


def _read(path: Path) -> tuple[dict[str, Array], float, str]:
    """Return the arrays of a trial, its rate in Hz, and from when to when the body moves."""
    found = read_hdf5(path, tuple(WIDTHS), ("movement",), ("sampling_rate",))
    arrays, rate = {key: found.arrays[key] for key in WIDTHS}, found.attributes["sampling_rate"]
    if not rate > 0:
        raise InputError(f"{path}, attribute 'sampling_rate': expected a rate in Hz, got {rate:g}")
    movement = np.flatnonzero(found.arrays.get("movement", np.zeros(0)))
    n = arrays["imu_gyr"].shape[0] if arrays["imu_gyr"].ndim else 0
    for key, width in WIDTHS.items():
        if arrays[key].shape != (n, width):
            raise InputError(f"{path}, {key}: expected shape ({n}, {width}), got {arrays[key].shape}")
    moving = f"{movement[0] / rate:.1f} to {movement[-1] / rate:.1f} s" if movement.size else "not marked"
    return arrays, rate, moving


CONVERTER = Converter(
    "broad",
    "a trial (.hdf5) of BROAD: one IMU on a free body, optical pose as a sensor",
    convert,
    {
        "optical_delay": Option(
            "s by which the optical stamps are late; not given: what the gyroscope shows", number("optical_delay")
        )
    },
)
