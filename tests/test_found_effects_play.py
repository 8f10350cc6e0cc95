"""A whole diagnosis, and its model played: what is left of the recording is about what the fit left."""

import pytest

from imubench.correction.export import write_model
from imubench.correction.read_model import read_model
from imubench.correction.replay import truth_of_motion
from imubench.correction.sensor_chain import Link, read_by
from imubench.diagnosis.budget import Budget
from imubench.diagnosis.pipeline import diagnose
from imubench.effects import VARIANTS
from imubench.format1 import read
from imubench.proof.case import make_case
from tests.concealed import rms

CELLS = {  # concealed -> what is found, its parameters, how long it is recorded
    "low_pass": ("low_pass", {"cutoff": 6.0, "channels": ["gyro", "accel"]}, 8.0),
    "accel_scale": ("accel_scale", None, 8.0),
    "rectification": ("unknown", None, 10.0),  # which no effect explains: it plays as the signal that was fitted
}
ENOUGH = 60.0  # s of processor time: the search is over by then


@pytest.mark.slow
@pytest.mark.parametrize("concealed", CELLS)
def test_what_a_diagnosis_found_plays(concealed, tmp_path):
    effect, parameters, seconds = CELLS[concealed]
    make_case(tmp_path / "recording", "pendulum", [(concealed, "imu1", parameters)], 3, "strong", seconds=seconds)
    recording, _ = read(tmp_path / "recording")
    found, evidence = diagnose(recording, budget=Budget(ENOUGH))
    assert [(f.effect, f.at) for f in found.findings] == [(effect, "imu1")]
    assert found.misfit[0] > 1.3  # it showed
    (tmp_path / "model").mkdir()
    write_model(found, evidence, tmp_path / "model")
    model, (imu,) = read_model(tmp_path / "model"), recording.imus
    truth = truth_of_motion(model.rig, model.motion, model.start, model.end - model.start, imu.rate)
    _, gyro, accel = read_by(truth, model.start, imu.time, imu.name, model.chain(imu.name))
    settled = imu.time > imu.time[0] + 1.0  # what a filter did before the first sample nobody tells
    left = [
        rms(((imu.gyro - gyro) / imu.gyro_noise_std)[settled]),
        rms(((imu.accel - accel) / imu.accel_noise_std)[settled]),
    ]
    assert max(left) < 1.1, left


@pytest.mark.parametrize("effect", [e for e in VARIANTS if e.settings], ids=lambda e: f"{e.name} {e.settings}")
def test_an_effect_is_known_by_the_settings_that_a_file_has(effect):
    """A file has lists where an effect has tuples."""
    told = {key: list(value) if isinstance(value, tuple) else value for key, value in effect.settings.items()}
    law = Link(effect.name, {}, told).law
    assert law is not None and (law.name, dict(law.settings)) == (effect.name, dict(effect.settings))
