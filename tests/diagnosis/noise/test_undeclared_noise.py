"""A noise that nobody declares, on recordings of the independent generator: seen above the motion, kept in the fit."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.samples.screening import check_samples, with_sample_noise
from imubench.format1 import read
from imubench.proof.case import make_case

TRUE = {"gyro": 0.0022, "accel": 0.0276}


def undeclared(folder, *effects, **options):
    levels = {f"{part}_noise": std for part, std in TRUE.items()}
    slow = {"seconds": 12.0, "rate": 50.0, "band": 1.9, "declare_noise": False, "encoder": True}
    make_case(folder / "case", "hinge", effects=list(effects), seed=5, **(slow | levels | options))
    return read(folder / "case")[0]


@pytest.mark.long
def test_both_imus_have_their_own_noise_where_one_hums(tmp_path):
    hum = ("vibration", "imu1", {"frequency": 20.6, "amplitude": [0.08, 0.17, 0.26]})
    start = begin(undeclared(tmp_path, hum))
    for name in ("imu2.gyro", "imu2.accel"):
        assert start.fit.noise[name] == pytest.approx(TRUE[name.split(".")[1]], rel=0.2), name
        assert declared(start.fit.model)[name] == pytest.approx(TRUE[name.split(".")[1]], rel=0.1), name


def test_a_declared_noise_stays_and_one_that_is_not_white_is_not_taken(tmp_path):
    recording = undeclared(tmp_path)
    samples = check_samples(recording)
    said = with_sample_noise(recording, (), {"imu1.gyro": 0.5})
    assert (said.imus[0].gyro_noise_std, said.imus[0].accel_noise_std) == (0.5, None)
    again = with_sample_noise(said, (), {"imu1.gyro": 0.7, "imu2.accel": 0.3})
    assert (again.imus[0].gyro_noise_std, again.imus[1].accel_noise_std) == (0.5, 0.3)
    assert set(samples.white) == {"imu1.gyro", "imu1.accel", "imu2.gyro", "imu2.accel"}
    quick = undeclared(tmp_path / "quick", rate=100.0, band=10.0, vigour=3.0)
    for name, std in check_samples(quick).white.items():
        assert std < 1.3 * TRUE[name.split(".")[1]]
    assert np.all([i.gyro_noise_std is None for i in quick.imus])


def test_a_dead_channel_has_no_noise_to_tell(tmp_path):
    recording = undeclared(tmp_path)
    dead = replace(recording.imus[1], gyro=np.zeros_like(recording.imus[1].gyro))
    assert set(check_samples(replace(recording, imus=(recording.imus[0], dead))).white) == {
        "imu1.gyro",
        "imu1.accel",
        "imu2.accel",
    }
