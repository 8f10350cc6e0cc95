"""How noise on the splines changes with a law's numbers: as rows say that are made anew for every number."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.noise import debias
from imubench.diagnosis.noise.debias import _slopes, changed, law_parameters
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.process_factors import state_rows
from imubench.diagnosis.solve.gauss_newton import all_rows, factored
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.refit import extended
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.jets import Jet
from imubench.proof.case import make_case

CASES = {
    "springs": ("hinge", (("rocking_mount", "imu2"), ("soft_mount", "imu1"))),
    "filter": ("pendulum", (("low_pass", "imu1"),)),
}


@pytest.fixture(scope="module", params=CASES)
def fit(request, tmp_path_factory):
    rig, effects = CASES[request.param]
    folder = tmp_path_factory.mktemp("laws") / "r"
    make_case(folder, rig, [], 4, seconds=4.0, rate=50.0)
    begun = extended(nominal_fit(read(folder)[0]), tuple(Hypothesis(EFFECTS[n], at) for n, at in effects))
    rng = np.random.default_rng(3)
    off = {n: v + 0.01 * rng.normal(size=v.shape) for n, v in begun.state.values.items()}
    state = State(begun.state.coefficients + 0.01 * rng.normal(size=begun.state.coefficients.shape), off)
    return replace(begun, state=state, rows=all_rows(begun.model, state, begun.noise, begun.anchor))


def moved_rows(fit, state, rows, moved):
    """What moved splines do to rows, by group, each row's Jacobian made."""
    out = {}
    for r in rows:
        whitened = replace(r, std=r.std * fit.noise.get(r.name, 1.0) * fit.loose)
        out[r.name] = linearise(whitened, fit.model.tracks, fit.model.parameters).along(moved)
    return out


def anew(fit, names, moved, drawn):
    """The same as `_slopes`, every row made anew."""
    for h, name, log in law_parameters(fit):
        places = [] if all(p.log for p in h.effect.parameters) else [h.at]

        def at(state, h=h, places=places):
            law = moved_rows(fit, state, state_rows(fit.model, state, h), moved)
            return law, moved_rows(fit, state, fit.model.measured(state, places), moved) if places else {}

        law, read_ = at(fit.state)
        left = law | {group: drawn[group] + x for group, x in read_.items()}
        for i, std in enumerate(fit.model.priors[name].std):
            value = fit.state.values[name].copy()
            value[i] += ALGEBRA.difference * std
            other, seen = at(State(fit.state.coefficients, fit.state.values | {name: value}))
            slope = {g: (x - law[g]) / (ALGEBRA.difference * std) for g, x in other.items()}
            yield (
                left,
                slope | ({} if log else {g: (x - read_[g]) / (ALGEBRA.difference * std) for g, x in seen.items()}),
            )


def test_slopes_are_those_of_rows_made_anew(fit):
    rng = np.random.default_rng(5)
    moved = 1e-3 * rng.normal(size=(*fit.state.coefficients.shape, 4))
    drawn = {r.name: rng.normal(size=(*r.residual.value.shape, 4)) for r in fit.measured}
    names = [name for _, name, _ in law_parameters(fit)]
    count = 0
    for (left, slope), (exact, change) in zip(
        _slopes(fit, names, moved, drawn), anew(fit, names, moved, drawn), strict=True
    ):
        assert left.keys() == exact.keys()
        for group, value in exact.items():
            assert_allclose(left[group], value, rtol=1e-9, atol=1e-9 * np.abs(value).max())
        largest = max(np.abs(x).max() for x in change.values())
        for group, value in change.items():
            # a difference of two products over a small step has lost so many digits
            assert_allclose(slope.get(group, 0.0 * value), value, atol=1e-6 * largest)
        count += 1
    assert count == sum(len(fit.state.values[n]) for n in names)


def test_derivatives_that_stay_are_no_change():
    a, b, c = np.ones((4, 3, 2)), np.full((1, 3, 3), 2.0), np.arange(12.0).reshape(4, 3, 1)
    before = Jet(np.zeros((4, 3)), {("a", 0): a, ("b", 1): b})
    after = Jet(np.zeros((4, 3)), {("a", 0): a.copy(), ("b", 1): 1.5 * b, ("c", 0): c})
    found = changed(before, after).blocks
    assert found.keys() == {("b", 1), ("c", 0)}
    assert_allclose(found["b", 1], 0.5 * b)
    assert_allclose(changed(after, before).blocks["c", 0], -c)


@pytest.mark.parametrize("columns", [1, 1000])
def test_it_is_the_same_however_many_draws_are_taken_at_once(fit, monkeypatch, columns):
    fit = solve(fit.model, fit.state, fit.noise, fit.anchor, steps=1)
    _, solution, parts = factored(fit.model, fit.rows)
    names = [name for _, name, _ in law_parameters(fit)]
    usual = debias.driven_by_noise(fit, solution, parts, names)
    monkeypatch.setattr(debias, "ALGEBRA", replace(ALGEBRA, columns=columns))
    other = debias.driven_by_noise(fit, solution, parts, names)
    for part in ("pull", "noise", "whole"):
        one, two = getattr(usual, part), getattr(other, part)
        assert_allclose(one, two, rtol=1e-9, atol=1e-9 * np.abs(one).max())
