"""A lone gyroscope beside a pose, of which few readings tell the noise: what they hold may be an effect."""

import pytest

from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.followed_sensor import at_levels, nearer_to_declared, uncertain_levels
from imubench.diagnosis.search.rounds import try_round
from imubench.diagnosis.search.selected import candidates
from imubench.format1 import read
from imubench.proof.case import make_case

QUICK = {
    "rate": 50.0,
    "band": 3.15,
    "vigour": 1.48,
    "gyro_noise": 0.0015,
    "accel_noise": 0.0154,
    "declare_noise": False,
}
MATRIX = [[-8e-5, -1.1e-4, -1.5e-4], [1.4e-4, -1.2e-4, -1.3e-4], [9e-5, -1.6e-4, -1.2e-4]]


@pytest.fixture(scope="module")
def pulled(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pulled") / "r"
    asked = [("g_sensitivity", "imu1", {"matrix": MATRIX})]
    make_case(folder, "free", asked, 20261126, seconds=15.0, **QUICK)
    return begin(read(folder)[0]).fit


@pytest.mark.slow
def test_what_few_readings_hold_is_an_effect_where_it_brings_their_level_down(pulled):
    """It is 4.6 times the declared one: beside such noise the effect was worth nothing."""
    assert list(uncertain_levels(pulled)) == ["imu1.gyro"]
    first, *_ = try_round(pulled, candidates(pulled.model), lambda _: None).tried
    assert (first.hypothesis.name, first.evidence > EVIDENCE.needed_nat) == ("g_sensitivity@imu1", True)
    assert nearer_to_declared(pulled, first, uncertain_levels(pulled))


@pytest.mark.long
def test_what_leaves_the_level_where_it_was_is_none(pulled):
    told = uncertain_levels(pulled)
    tried = try_round(at_levels(pulled, told), [h for h in candidates(pulled.model) if "drift" in h.name], print).tried
    assert tried
    assert not any(nearer_to_declared(pulled, t, told) for t in tried)


@pytest.mark.long
def test_a_clean_gyroscope_is_not_too_loud(tmp_path):
    make_case(tmp_path / "r", "free", [], 20261126, seconds=15.0, **QUICK)
    assert uncertain_levels(begin(read(tmp_path / "r")[0]).fit) == {}
