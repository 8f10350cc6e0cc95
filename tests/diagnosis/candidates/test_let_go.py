"""Limbs that are let go on a fixed base: a hinge of whose two IMUs one rests."""

import numpy as np
import pytest

from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.solve.initialize import model_of
from imubench.format1 import read
from imubench.proof.case import make_case

RATES = ((50.0, 200.0), (100.0, 50.0))


@pytest.fixture(scope="module", params=RATES, ids=["slow base", "quick base"])
def made(request, tmp_path_factory):
    """A clean recording whose IMUs keep different rates: the one on the base first."""
    out = tmp_path_factory.mktemp("swing") / "case"
    one, two = request.param
    make_case(out, "hinge", [], 9, base="fixed", swing=True, seconds=12.0, rate=one, rate2=two)
    return read(out)[0], two


def test_knots_are_as_dense_as_the_samples_of_the_imu_that_moves(made):
    recording, rate = made
    assert model_of(recording).tracks.knots.step == pytest.approx(1 / min(rate, 128.0), rel=0.01)


def test_the_jerk_of_letting_go_leaves_nothing_but_noise(made):
    recording, _ = made
    fit = begin(recording).first
    rows = next(r for r in fit.measured if r.name == "imu2.accel")
    start = recording.free_swings[0][0] - fit.model.start
    near = np.abs(rows.time - start) < 0.4
    power = np.mean(rows.whitened**2, axis=1)
    assert near.sum() > 30
    assert np.mean(power[near]) < 1.6 * np.mean(power[~near])


@pytest.mark.long
def test_nothing_is_said_of_it(made):
    assert diagnose(made[0])[0].findings == ()
