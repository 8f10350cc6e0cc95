"""What a mount that turns adds to the readings, against recordings of the independent generator with and without it."""

import numpy as np
import pytest

from imubench.diagnosis.config.discrepancy import BASIS
from imubench.diagnosis.discrepancy.candidate_terms import sensor_terms
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.format1 import read
from imubench.jets import skew
from imubench.proof.case import make_case

ROTATION, CONSTANT = np.array([0.003, -0.002, 0.004]), 0.15 * 8.0  # rad, s
SETTLES = "time: the sensor turns and settles"


@pytest.mark.long
def test_a_sensor_that_creeps_reads_how_fast_it_turns_as_well(tmp_path):
    """Seed and noise are the same: what is between the samples is the creep alone, here and on average."""
    creep = {"rotation": ROTATION.tolist(), "time_constant": CONSTANT}
    for name, effects in (("without", []), ("with", [("creep", "imu1", creep)])):
        make_case(tmp_path / name, "hinge", effects, 5, seconds=8.0, rate=100.0)
    still, turned = (read(tmp_path / name)[0].imus[0] for name in ("without", "with"))
    fit = nominal_fit(read(tmp_path / "without")[0])
    (term,) = [t for t in sensor_terms(fit, fit.model.recording.imus[0]) if t.goes_with == SETTLES]
    columns, added = [], []
    for part, std in (("gyro", still.gyro_noise_std), ("accel", still.accel_noise_std)):
        on_average = skew(getattr(still, part)).reshape(-1, 3)
        columns.append(np.hstack([term.signals[part].reshape(-1, term.count), on_average]) / std)
        added.append((getattr(turned, part) - getattr(still, part)).reshape(-1) / std)
    matrix, difference = np.concatenate(columns), np.concatenate(added)
    weights = np.linalg.lstsq(matrix, difference, rcond=None)[0]
    assert np.sum(np.square(difference - matrix @ weights)) < 1e-3 * np.sum(np.square(difference))
    told = BASIS.turn_rad * weights[: term.count].reshape(3, -1)
    assert told[:, 1] == pytest.approx(ROTATION, rel=0.02)
    assert told[:, [0, 2]] == pytest.approx(0.0, abs=2e-5)
