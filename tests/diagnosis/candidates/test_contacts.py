"""A stop that is met once or twice is told from the equation of a free swing, which fails for a moment."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.candidates import end_stop_contacts as contacts_module
from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.candidates.end_stop_contacts import (
    beside,
    contact_stop,
    contacts,
    failures,
    level_axis,
    stop_from,
)
from imubench.diagnosis.config.samples import HIGH_BAND
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.residuals import SWING_EQUATION
from imubench.format1 import read
from imubench.proof.case import make_case


def swinging(tmp_path, rig, effects, seed, **options):
    truth = make_case(tmp_path / "r", rig, effects, seed, seconds=12.0, swing=True, **options)
    return truth, read(tmp_path / "r")[0]


@pytest.mark.long
@pytest.mark.parametrize("seed", [221, pytest.param(213, marks=pytest.mark.slow)])
def test_a_pendulums_stop_is_found_where_it_pushes_back(seed, tmp_path):
    """The other way round along its axis the angle has the other sign: the heading is not known."""
    truth, recording = swinging(tmp_path, "pendulum", [("end_stop", "joint")], seed)
    (said,) = [f for f in begin(recording).samples.findings if f.effect == "end_stop"]
    angle = said.parameters["angle"]
    assert angle.std < 0.03
    assert abs(angle.value - abs(truth["effects"][0]["parameters"]["angle"])) < 2 * angle.std


def test_a_swing_without_a_stop_fails_nowhere(tmp_path):
    _, recording = swinging(tmp_path, "pendulum", [("viscous_friction", "joint")], 221)
    fit = nominal_fit(recording)
    assert not failures(fit).size
    assert contact_stop(fit, recording.free_swings, lambda _: pytest.fail("there is nothing to leave out")) is None


def test_hinges_have_their_stop_on_one_side(tmp_path, monkeypatch):
    truth, recording = swinging(tmp_path, "hinge", [("end_stop", "joint")], 222, base="fixed")
    first = nominal_fit(recording)
    assert failures(first).size
    stop = contact_stop(
        first, recording.free_swings, lambda swings: nominal_fit(replace(recording, free_swings=swings))
    )
    assert stop is not None
    assert stop.angle == pytest.approx(truth["effects"][0]["parameters"]["angle"], abs=0.03)

    ways = iter([1.0, -1.0])
    monkeypatch.setattr(contacts_module, "pushed", lambda *_: (np.array([0.0, next(ways), 0.0]), np.array([0, 0, 1.0])))
    assert stop_from(first, recording.body, [(2.0, 2.2), (3.0, 3.2)], recording.free_swings) is None


def test_what_fails_most_counts_and_what_is_smeared_about_it_does_not(tmp_path):
    _, recording = swinging(tmp_path, "pendulum", [], 221)
    fit = nominal_fit(recording)
    rows = next(r for r in fit.rows if r.name == SWING_EQUATION)
    value = rows.residual.value.copy()
    size = float(np.median(np.linalg.norm(value / rows.std, axis=1))) * float(np.mean(rows.std))
    for i, times in ((100, 60), (110, 40), (400, 30), (500, 10)):
        value[i] = [0.0, times * size, 0.0]
    broken = replace(rows, residual=replace(rows.residual, value=value))
    struck = replace(fit, rows=[broken if r is rows else r for r in fit.rows])
    assert np.allclose(np.sort(failures(struck)), rows.time[[100, 400]] + fit.model.start)


@pytest.mark.long
def test_contacts_that_lie_together_are_one(tmp_path):
    _, recording = swinging(tmp_path, "pendulum", [], 221)
    fit = nominal_fit(recording)
    times = fit.model.start + np.array([2.0, 2.0 + HIGH_BAND.one_knock_s / 2, 5.0])
    one, other = contacts(times, fit)
    assert one[0] < 2.0 and one[1] > 2.0 + HIGH_BAND.one_knock_s / 2
    assert other[0] < 5.0 < other[1] < 5.2
    assert beside(((1.0, 4.0),), np.array([2.0])) == ((1.0, pytest.approx(1.94)), (pytest.approx(2.06), 4.0))


@pytest.mark.parametrize("heading", [0.0, 1.3, -2.5])
@pytest.mark.parametrize("along", ["gradient", "upright"])
def test_a_push_tells_the_axis_of_the_swing(heading, along):
    """Of the level axis e and the limb's axis z a stop pushes along (e - z_e z) / (1 - z_e^2), or about e itself."""
    e, forward = np.array([-np.sin(heading), np.cos(heading), 0.0]), np.array([np.cos(heading), np.sin(heading), 0.0])
    swing, aside = 0.7, 0.3
    limb = np.cos(aside) * (np.sin(swing) * forward + np.cos(swing) * np.array([0, 0, 1.0])) + np.sin(aside) * e
    push = -0.2 * ((e - (limb @ e) * limb) / (1 - (limb @ e) ** 2) if along == "gradient" else e)
    assert level_axis(push, limb) == pytest.approx(e)


def test_a_push_that_turns_a_limb_about_itself_is_no_stops():
    limb = np.array([np.sin(0.7), 0.0, np.cos(0.7)])
    assert level_axis(0.2 * limb + np.array([0.0, 0.1, 0.0]), limb) is None
