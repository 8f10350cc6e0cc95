"""A diagnosis as `imubench diagnose` writes it: diagnosis.json and the folder model/, beside its recording."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from fuzz.seeds import laid_out, recordings
from imubench.answers import write_json
from imubench.correction.export import write_model
from imubench.diagnosis.evidence import Evidence, FittedEffect, Level, Played, Pose, Trace
from imubench.diagnosis.result import (
    Baseline,
    Change,
    Diagnosis,
    Finding,
    FitQuality,
    Interval,
    Move,
    Noise,
    Own,
    Parameter,
    Rejected,
    SensorErrors,
    Unseen,
    Where,
)
from imubench.diagnosis.result_file import FILE_NAME, as_dict
from imubench.recording import Recording

GAIN = Interval(100.0, (90.0, 110.0))
SOFT = {"frequency": Parameter([11.0, 12.0, 13.0], np.full(3, 0.1), "Hz"), "damping_ratio": Parameter(0.1, 0.01, "1")}
BIAS = {"bias": Parameter([0.1, -0.2, 0.3], np.full(3, 0.01), "rad/s")}
LATE = {"offset": Parameter(0.02, 1e-4, "s")}
MOVES = {"joint_axis": Move([0.2, 0.1], "deg"), "hinge_angle": Move(0.3, "deg RMS")}
WHERE = Where("imu2", {"acc_x": 0.61}, ((9.0, 16.0),), ((0.5, 1.5),), "hinge reversals", 0.97)


def diagnosis(*findings: Finding) -> Diagnosis:
    """Return the diagnosis of the seed's recording with everything in it that the file can hold."""
    quality = FitQuality(
        (4.9, 1.0),
        Change({"imu2.acc_x": 3.1}, {"imu2.acc_x": 1.1}, "1"),
        Change({"hinge_angle": 0.05}, {"hinge_angle": 0.01}, "rad RMS"),
    )
    rejected = (Rejected("low_pass", "imu2", -900.0),)
    unseen = (Unseen("a scale", "turn about every axis"),)
    noise = {"imu1.gyro": Noise(0.002, "rad/s", "declared"), "imu2.accel": Noise(0.02, "m/s^2", "rest")}
    known = (Own("gyro_bias", "imu1", BIAS),)
    sensors = (
        SensorErrors("imu1", 50.0, {"gyro": 35.0}, known, np.eye(3)),
        SensorErrors("imu2", 50.0, {}, (replace(known[0], at="imu2"),), np.eye(3)),
    )
    return Diagnosis(
        *(
            "seed",
            "hinge",
            "explained",
            (4.7, 1.0),
            (WHERE,),
            findings,
            rejected,
            quality,
            "model/hinge.xml",
            2.0,
            unseen,
        ),
        noise=noise,
        sensors=sensors,
        baseline=Baseline("still", known),
    )


BIASED = Finding(
    "gyro_bias", "imu2", 0.98, BIAS, GAIN, (Rejected("gyro_drift", "imu2", 90.0),), "rest", WHERE, MOVES, False
)
SPRUNG = Finding("soft_mount", "imu2", 0.9, SOFT, GAIN)
DELAYED = Finding("time_offset", "imu2", 0.9, LATE, GAIN)
NAMELESS = Finding("unknown", "imu1", 0.4, {}, GAIN)  # in doubt: the verdict is as without it


def evidence(recording: Recording) -> Evidence:
    """Return what a fit would show of the seed's recording: a motion at knots, its mounts, levels of noise."""
    stamps = recording.imus[0].time
    time = np.arange(stamps[0] - 0.2, stamps[-1] + 0.2, 0.05)
    turn = np.stack([np.cos(0.3 * np.sin(time)), np.sin(0.3 * np.sin(time)), 0 * time, 0 * time], axis=1)
    force = np.stack([np.sin(time), np.cos(time), 9.81 + 0 * time], axis=1)
    hum = {"gyro": 0.01 * force, "accel": 0.1 * force}
    fitted = (FittedEffect("unknown", "imu1", time=time - stamps[0], signals=hum),)
    motion = Played(time, turn, np.zeros((time.size, 3)), 0.5 * np.sin(2 * time), force, fitted)
    mounts = {imu.name: Pose(imu.mount_position, imu.mount_quaternion) for imu in recording.imus}
    trace = Trace("imu1", "gyro", ("gyr_x", "gyr_y", "gyr_z"), "rad/s", stamps, np.zeros((stamps.size, 3)), 1.0)
    groups = [f"{imu}.{part}" for imu in mounts for part in ("gyro", "accel")] + ["encoder.angle"]
    return Evidence(recording, (trace,), motion, mounts, tuple(Level(g, "1", None, 1e-3, 1e-3) for g in groups))


@laid_out
def model(folder: Path) -> None:
    """Write model/ with a spring, a bias, a delay and what has no name in it."""
    recording, _ = recordings.recorded()
    (folder / "model").mkdir()
    write_model(diagnosis(BIASED, SPRUNG, DELAYED, NAMELESS), evidence(recording), folder / "model")


@laid_out
def diagnosed(folder: Path) -> None:
    """Write a recording, and beside it a diagnosis with its model."""
    recording, _ = recordings.recorded()
    recordings.write(folder / "recording")
    (folder / "diagnosis" / "model").mkdir(parents=True)
    found = diagnosis(BIASED, DELAYED)
    write_model(found, evidence(recording), folder / "diagnosis" / "model")
    write_json(folder / "diagnosis" / FILE_NAME, as_dict(found))
