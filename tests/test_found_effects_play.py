"""A whole diagnosis, and its model played: what is left of the recording is about what the fit left."""

import numpy as np
import pytest

from imubench.diagnosis.diagnose import diagnose
from imubench.diagnosis.export import write_model
from imubench.diagnosis.read_model import read_model
from imubench.diagnosis.replay import played_through
from imubench.diagnosis.sensor_chain import read_by
from imubench.format1 import read
from imubench.proof.case import make_case
from tests.concealed import rms

CELLS = [
    ("low_pass", {"cutoff": 6.0, "channels": ["gyro", "accel"]}),
    ("saturation", None),
    ("gyro_bias", None),
]


@pytest.mark.slow
@pytest.mark.parametrize(("effect", "parameters"), CELLS, ids=[name for name, _ in CELLS])
def test_what_a_diagnosis_found_plays(effect, parameters, tmp_path):
    make_case(tmp_path / "recording", "pendulum", [(effect, "imu1", parameters)], 3, "strong", seconds=8.0)
    recording, _ = read(tmp_path / "recording")
    found, evidence = diagnose(recording)
    if effect != "gyro_bias":  # of one IMU on a ball joint a bias is seen only as far as the joint shows it
        assert effect in {f.effect for f in found.findings}
    (tmp_path / "model").mkdir()
    write_model(found, evidence, tmp_path / "model")
    model, (imu,) = read_model(tmp_path / "model"), recording.imus
    truth = played_through(model.rig, model.motion, model.start, model.end - model.start, imu.rate)
    _, gyro, accel = read_by(truth, model.start, imu.time, imu.name, model.chain(imu.name))
    settled = imu.time > imu.time[0] + 1.0  # what a filter did before the first sample nobody tells
    left = [
        rms(((imu.gyro - gyro) / imu.gyro_noise_std)[settled]),
        rms(((imu.accel - accel) / imu.accel_noise_std)[settled]),
    ]
    assert max(left) < 1.1 * max(1.0, np.sqrt(found.misfit[1])), left
