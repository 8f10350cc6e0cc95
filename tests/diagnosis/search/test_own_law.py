"""When a sensor's own law explains what a fit leaves, and no spring is sought; and when a pivot is, beside springs."""

import pytest

import imubench.diagnosis.search.rounds as rounds
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.discrepancy.input_nonlinearity import reads_by_own_law
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.dynamic_candidates import CLEARLY
from imubench.diagnosis.search.rounds import dynamic_trials, try_round
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

DEAD_ZONE = ("dead_band", "imu2", {"channel": "gyro", "width": 0.05})


def fit_of(tmp_path, rig, effects, seed, **options):
    make_case(tmp_path / "r", rig, effects, seed, **options)
    return nominal_fit(read(tmp_path / "r")[0])


@pytest.mark.long
@pytest.mark.parametrize(
    ("rig", "effects", "own"),
    [
        ("hinge", [DEAD_ZONE], True),
        ("hinge", [], False),
        ("hinge", [("rocking_mount", "imu2")], False),
        ("hinge", [("skin_sliding", "imu1")], False),
        ("pendulum", [("moving_pivot", "joint")], False),
    ],
)
def test_a_dead_zone_is_a_law_of_the_reading_and_nothing_that_moves_is(tmp_path, rig, effects, own):
    """Once a scale has its share: it is what a dead zone looks like first."""
    fit = fit_of(tmp_path, rig, effects, 63, seconds=8.0, band=2.0)
    at = "imu2" if rig == "hinge" else "imu1"
    assert reads_by_own_law(with_noise(refit(fit, (Hypothesis(EFFECTS["gyro_scale"], at),)))) == own


@pytest.mark.slow
def test_no_spring_is_sought_beside_a_dead_zone(tmp_path, monkeypatch):
    fit = fit_of(tmp_path, "hinge", [DEAD_ZONE], 63, seconds=8.0, band=2.0)
    assert misfit(fit) > ADMISSION.unexplained_misfit
    asked = []
    monkeypatch.setattr(rounds, "state_trials", lambda fit, alive, *rest: asked.append(alive) or [])
    tried = try_round(fit, candidates(fit.model), lambda _: None)
    assert asked == [[]]
    assert not tried.lively


@pytest.mark.slow
def test_a_dead_zone_has_no_name_and_its_place(tmp_path):
    make_case(tmp_path / "r", "hinge", [DEAD_ZONE], 63, seconds=12.0, band=2.0)
    found = diagnose(read(tmp_path / "r")[0])[0].findings
    assert [(f.effect, f.at) for f in found] == [("unknown", "imu2")]


@pytest.mark.parametrize(("nat", "asked"), [(2 * CLEARLY, True), (CLEARLY / 2, False)])
def test_splines_without_a_law_are_asked_where_springs_alone_explain_much(tmp_path, monkeypatch, nat, asked):
    """What springs stand for may be a pivot that leaves a lone IMU little: it is held against them then."""
    fit = fit_of(tmp_path, "pendulum", [], 5, seconds=4.0, band=2.0)
    left = candidates(fit.model)
    springs = [h for h in left if h.effect.lawful]
    calls = []

    def trials(fit, alive, *rest):
        calls.append({h.name for h in alive})
        return [Trial(alive[0], fit, nat if alive == springs else 3 * nat)]

    monkeypatch.setattr(rounds, "state_trials", trials)
    found = dynamic_trials(fit, left, springs, lambda _: None, 5.0, None)
    assert calls == [{h.name for h in springs}] + [{h.name for h in left if h.effect.free}] * asked
    assert [t.evidence for t in found] == ([3 * nat, nat] if asked else [nat])


def test_what_has_a_law_comes_first_unless_a_spline_explains_a_third_more(tmp_path, monkeypatch):
    fit = fit_of(tmp_path, "pendulum", [], 5, seconds=4.0, band=2.0)
    springs = [h for h in candidates(fit.model) if h.effect.lawful]
    monkeypatch.setattr(
        rounds, "state_trials", lambda fit, alive, *rest: [Trial(alive[0], fit, 300.0 if alive == springs else 390.0)]
    )
    found = dynamic_trials(fit, candidates(fit.model), springs, lambda _: None, 5.0, None)
    assert [t.evidence for t in found] == [300.0, 390.0]
