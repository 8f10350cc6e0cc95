"""A search that begins where another has ended takes its rows over: they are those that would be made anew."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, Prior
from imubench.diagnosis.problem.motion_prior import is_prior, prior_rows
from imubench.diagnosis.solve import levenberg_marquardt
from imubench.diagnosis.solve.gauss_newton import all_rows, equation_rows, own_rows
from imubench.diagnosis.solve.levenberg_marquardt import search
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.jets import derivatives_by
from imubench.proof.case import make_case

PLAY, MOUNT = Hypothesis(EFFECTS["joint_play"], "joint"), Hypothesis(EFFECTS["soft_mount"], "imu2")


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("levels") / "r"
    make_case(folder, "hinge", [], 4, seconds=4.0, rate=50.0)
    return refit(nominal_fit(read(folder)[0]), (PLAY, MOUNT), steps=2)


def louder(fit):
    return {name: std * (1.3 if "gyro" in name else 0.8) for name, std in fit.noise.items()}


@pytest.fixture
def made(monkeypatch):
    """The states at which rows are made anew."""
    states = []

    def counted(model, state, *more):
        states.append(state)
        return all_rows(model, state, *more)

    monkeypatch.setattr(levenberg_marquardt, "all_rows", counted)
    return states


def same(rows, others):
    for one, other in zip(rows, others, strict=True):
        assert one.name == other.name
        assert_allclose(one.whitened, other.whitened, rtol=1e-12, atol=1e-12)  # rounding of the levels
        assert_allclose(one.std, other.std, rtol=1e-14)
        for key, block in one.residual.blocks.items():
            assert np.array_equal(block, other.residual.blocks[key])


def test_rows_are_taken_over_where_only_levels_and_pulls_change(fit, made):
    log = next(p for p in MOUNT.effect.parameters if p.log)
    pulled = replace(fit.model, tilts={MOUNT.key(log.name): Prior(np.full(log.width, 0.1), np.ones(log.width))})
    for model in (fit.model, pulled):
        found, _ = search(model, fit.state, louder(fit), fit.anchor, steps=0)
        assert made == []
        same(found.rows, all_rows(model, fit.state, louder(fit), fit.anchor))


def test_a_search_from_there_is_the_same(fit, made):
    one, _ = search(fit.model, fit.state, louder(fit), fit.anchor, steps=2)
    assert all(state is not fit.state for state in made)
    other, _ = search(fit.model, replace(fit.state), louder(fit), fit.anchor, steps=2)
    assert one.cost == pytest.approx(other.cost, rel=1e-9)
    assert_allclose(one.state.coefficients, other.state.coefficients, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("part", ["masks", "louder", "hypotheses"])
def test_rows_of_another_problem_are_made_anew(fit, made, part):
    gyro = "imu1.gyro"
    count = len(fit.model.stamps[gyro])
    other = {
        "masks": {gyro: np.arange(count) > 5},
        "louder": {gyro: np.full(count, 2.0)},
        "hypotheses": (PLAY, Hypothesis(EFFECTS["soft_mount"], "imu2")),
    }[part]
    model = replace(fit.model, **{part: other})
    found, _ = search(model, fit.state, fit.noise, fit.anchor, steps=0)
    assert made == [fit.state]
    same(found.rows, all_rows(model, fit.state, fit.noise, fit.anchor))


def test_priors_are_told_from_measurements_and_laws(fit):
    priors = list(prior_rows(fit.model, fit.state, fit.noise, fit.anchor))
    assert priors
    assert all(is_prior(r) for r in priors)
    others = [*fit.model.measured(fit.state), *equation_rows(fit.model, fit.state)]
    assert len(others) > 4
    assert not any(is_prior(r) for r in others)


def test_rows_of_own_splines_are_those_of_all_that_depend_on_them(fit):
    own = [h.key(s.name) for h in (PLAY, MOUNT) for s in h.effect.states]
    with derivatives_by(own):
        rows = [r for r in all_rows(fit.model, fit.state, louder(fit), fit.anchor) if r.residual.blocks]
    found = own_rows(fit.model, fit.state, louder(fit), 1.0, (), own)
    by_name = {r.name: r for r in found}
    assert by_name.keys() == {r.name for r in rows}
    same([by_name[r.name] for r in rows], rows)
