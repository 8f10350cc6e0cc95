"""What went wrong in earlier designs of the diagnosis, each shown to be a trap and to be avoided."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.stats import chi2

import imubench.diagnosis.noise.nominal as nominal
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.criteria.score_test import score
from imubench.diagnosis.noise.declared_noise import declared, misfit
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.residual_checks.localize import locate
from imubench.diagnosis.residual_checks.regressors import regressors
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.gauss_newton import Step, all_rows
from imubench.diagnosis.solve.initialize import model_of
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.solve.retract import moved
from imubench.format1 import read
from imubench.proof.case import make_case

SECONDS = 12.0


def recorded(folder, effects, seed, seconds=SECONDS, **options):
    make_case(folder / "r", "hinge", effects, seed, seconds=seconds, **options)
    return read(folder / "r")[0]


def plain(fit):
    """Hypotheses without states or grids."""
    return [h for h in candidates(fit.model) if not h.effect.states and not h.effect.grid(1.0)]


@pytest.mark.slow
def test_a_spline_too_coarse_looks_like_a_sensor_of_its_own(tmp_path, monkeypatch):
    recording = recorded(tmp_path, [], 5, band=6.0)
    assert misfit(nominal_fit(recording)) < ADMISSION.unexplained_misfit
    monkeypatch.setattr(nominal, "model_of", partial(model_of, knots_per_s=12.0))
    assert misfit(nominal_fit(recording)) > ADMISSION.unexplained_misfit


@pytest.mark.slow
def test_a_dense_spline_does_not_swallow_a_hum(tmp_path):
    truth = make_case(tmp_path / "r", "hinge", [("vibration", "imu2")], 8, seconds=20.0)["effects"][0]["parameters"]
    found = diagnose(read(tmp_path / "r")[0])[0].findings
    assert [(f.effect, f.at) for f in found] == [("vibration", "imu2")]
    size = np.linalg.norm(truth["amplitude"])
    assert np.linalg.norm(found[0].parameters["amplitude"].value) == pytest.approx(size, rel=0.1)


@pytest.mark.slow
def test_an_undamped_step_from_far_makes_it_worse_and_the_fit_does_not(tmp_path):
    fit = nominal_fit(recorded(tmp_path, [], 6))
    rng = np.random.default_rng(1)
    off = fit.state.coefficients + 0.3 * rng.standard_normal(fit.state.coefficients.shape)
    far = replace(fit.state, coefficients=off)
    rows = all_rows(fit.model, far, fit.noise, fit.anchor)
    step = Step.of(fit.model, rows)
    x, values = step.splines, step.values
    cost = sum(r.cost for r in rows)
    undamped = sum(r.cost for r in all_rows(fit.model, moved(fit.model, far, x, values), fit.noise, fit.anchor))
    assert undamped > cost
    costs = [solve(fit.model, far, fit.noise, fit.anchor, steps=n).cost for n in (1, 3, 10)]
    assert cost > costs[0] > costs[1] > costs[2]


@pytest.fixture(scope="module")
def biased(tmp_path_factory):
    """A fit without the offset of imu1's gyroscope that its recording has."""
    return nominal_fit(recorded(tmp_path_factory.mktemp("biased"), [("gyro_bias", "imu1")], 1))


@pytest.mark.long
def test_the_channel_with_the_largest_residual_is_not_the_source(biased):
    weighed = fit_summary.weighed(biased, declared(biased.model))
    assert locate(fit_summary.traces(weighed), regressors(biased))[0].at == "imu2"
    best = max(score(biased, plain(biased)), key=lambda s: s.evidence)
    assert best.hypothesis.name == "gyro_bias@imu1"


def test_probabilities_underflow_where_evidence_still_ranks(biased):
    ranked = sorted(score(biased, plain(biased)), key=lambda s: -s.evidence)[:2]
    assert all(chi2.sf(2 * s.evidence, 3) < 1e-150 for s in ranked)
    assert ranked[0].evidence - ranked[1].evidence > 50


@pytest.mark.slow
def test_an_exact_refit_takes_back_a_wrong_score(tmp_path):
    fit = nominal_fit(recorded(tmp_path, [("gyro_scale", "imu1", {"scale": [0.03, -0.02, 0.025]})], 3))
    tried = {}
    for s in sorted(score(fit, plain(fit)), key=lambda s: -s.evidence)[:3]:
        after = refit(fit, (s.hypothesis,))
        tried[s.hypothesis.name] = after.cost
    assert min(tried, key=lambda name: tried[name]) == "gyro_scale@imu1"


@pytest.mark.slow
def test_with_the_labels_swapped_the_verdict_swaps(tmp_path):
    recording = recorded(tmp_path, [("accel_bias", "imu2")], 9)
    one, two = recording.imus
    swapped = replace(recording, imus=(replace(two, name="imu1"), replace(one, name="imu2")))
    said = [[(f.effect, f.at) for f in diagnose(r)[0].findings] for r in (recording, swapped)]
    assert said == [[("accel_bias", "imu2")], [("accel_bias", "imu1")]]
