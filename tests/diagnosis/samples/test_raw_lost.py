"""How many samples are lost, beside gaps in which a link was down."""

import numpy as np
import pytest

from imubench.diagnosis.samples.checks import check
from imubench.diagnosis.samples.sample_faults import missing_in_a_row
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.mark.parametrize(("fraction", "seed"), [(0.08, 1), (0.08, 2), (0.13, 3), (0.25, 4), (0.25, 5)])
def test_a_gap_is_no_lost_sample(tmp_path, fraction, seed):
    """With two gaps of up to 0.3 s counted in, 8 % were 11 %, and 4 standard deviations off."""
    lost = ("dropouts", "imu1", {"fraction": fraction, "mode": "missing"})
    make_case(tmp_path / "r", "pendulum", [lost], seed, seconds=15.0, rate=100.0, gaps=2)
    imu = read(tmp_path / "r")[0].imu("imu1")
    (found,) = [f for f in check(imu).findings if f.effect == "dropouts"]
    value, std, _ = found.parameters["fraction"]
    assert abs(value - fraction) < 2.6 * std < 0.1 * np.sqrt(fraction)


def test_runs_that_single_losses_make_count():
    rng = np.random.default_rng(3)
    lost = rng.random(1500) < 0.3
    edges = np.flatnonzero(np.diff(np.concatenate([[0], lost.astype(int), [0]])))
    runs = (edges[1::2] - edges[::2]).astype(float)
    assert missing_in_a_row(runs, int(np.sum(~lost))).sum() == lost.sum()
    assert missing_in_a_row(np.append(runs, 30.0), int(np.sum(~lost))).sum() == lost.sum()
    assert not missing_in_a_row(np.array([20.0, 25.0]), 1500).size
