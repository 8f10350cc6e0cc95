"""A recording may name the profile of its IMU: that declares the noise where its owner does not."""

import tomllib
from dataclasses import replace
from math import hypot, sqrt

import numpy as np
import pytest

from imubench.diagnosis.evidence import Level
from imubench.diagnosis.residual_checks.fit_summary import noise_of
from imubench.errors import InputError
from imubench.format1 import read_recording, write_recording
from imubench.recording import Imu, Recording

RATE = 50.0  # Hz, not the profile's own
MTW = 0.05 * np.pi / 180 * sqrt(RATE / 2), 0.003 * sqrt(RATE / 2)  # 0.05 deg/s and 3 mm/s^2 per sqrt(Hz)


def named(folder, text):
    """Return the folder of a recording whose IMU has one more line in recording.toml."""
    t = np.arange(100) / RATE
    up = np.tile([0.0, 0.0, 9.81], (100, 1))
    write_recording(Recording("r", "free", imus=(Imu("imu1", t, 0.0 * up, up, RATE),)), folder)
    path = folder / "recording.toml"
    path.write_text(path.read_text().replace("rate = 50.0\n", f"rate = 50.0\n{text}\n"))
    return folder


def test_it_declares_the_noise_at_the_recording_s_rate(tmp_path):
    (imu,) = read_recording(named(tmp_path / "r", 'profile = "xsens_mtw"')).imus
    assert imu.profile == "xsens_mtw"
    assert (imu.gyro_noise_std, imu.accel_noise_std) == pytest.approx(MTW)


def test_rounding_counts(tmp_path):
    (imu,) = read_recording(named(tmp_path / "r", 'profile = "mpu9250"')).imus
    folded = 0.01 * sqrt(np.pi / 2 * 92)  # deg/s: 0.01 per sqrt(Hz) behind a first-order filter of 92 Hz
    assert imu.gyro_noise_std == pytest.approx(hypot(folded, 1 / 16.4 / sqrt(12)) * np.pi / 180)  # 16.4 LSB/(deg/s)


def test_a_std_of_the_owner_s_counts(tmp_path):
    folder = named(tmp_path / "r", 'profile = "xsens_mtw"\ngyro_noise_std = 0.5')
    (imu,) = read_recording(folder).imus
    assert imu.gyro_noise_std == 0.5
    assert imu.accel_noise_std == pytest.approx(MTW[1])


def test_a_profile_without_noise_declares_none(tmp_path):
    (imu,) = read_recording(named(tmp_path / "r", 'profile = "perfect"')).imus
    assert (imu.gyro_noise_std, imu.accel_noise_std) == (None, None)


def test_an_unknown_profile_is_one_line(tmp_path):
    with pytest.raises(InputError, match=r"recording\.toml.*unknown IMU profile 'xsens'; known: .*xsens_mtw"):
        read_recording(named(tmp_path / "r", 'profile = "xsens"'))


def test_what_is_written_names_it_still(tmp_path):
    recording = read_recording(named(tmp_path / "r", 'profile = "xsens_mtw"\naccel_noise_std = 0.5'))
    write_recording(recording, tmp_path / "again")
    (entry,) = tomllib.loads((tmp_path / "again" / "recording.toml").read_text())["imu"]
    assert entry["profile"] == "xsens_mtw"
    assert "gyro_noise_std" not in entry
    assert entry["accel_noise_std"] == 0.5
    (imu,) = read_recording(tmp_path / "again").imus
    assert imu.gyro_noise_std == recording.imus[0].gyro_noise_std


def test_a_diagnosis_says_that_the_noise_is_a_profile_s(tmp_path):
    recording = read_recording(named(tmp_path / "r", 'profile = "xsens_mtw"\naccel_noise_std = 0.5'))
    levels = [
        Level("imu1.gyro", "rad/s", recording.imus[0].gyro_noise_std, 0.1, 0.1),
        Level("imu1.accel", "m/s^2", 0.5, 0.5, 0.5),
    ]
    assert {name: n.source for name, n in noise_of(levels, recording).items()} == {
        "imu1.gyro": "profile", "imu1.accel": "declared",
    }  # fmt: skip
    bare = replace(recording, imus=(replace(recording.imus[0], gyro_noise_std=None),))
    assert noise_of([replace(levels[0], declared=None)], bare)["imu1.gyro"].source == "unknown"
