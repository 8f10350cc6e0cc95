"""Steps of the motion fit, and what columns promise beside it, against direct computation."""

import numpy as np
import pytest

from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.criteria.onset_scan import After
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.solve.gauss_newton import Step, all_rows
from imubench.diagnosis.solve.levenberg_marquardt import solve, with_centre_velocity
from imubench.diagnosis.solve.retract import moved
from imubench.diagnosis.solve.schur import Base, promise
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("steps") / "case"
    make_case(folder, effects=[("gyro_bias", "imu2")], seed=21, seconds=8.0)
    return nominal_fit(read(folder)[0])


def cost(fit, state):
    return sum(r.cost for r in all_rows(fit.model, state, fit.noise, fit.anchor))


def disturbed(fit, size=0.02):
    rng = np.random.default_rng(4)
    noise = rng.normal(scale=size, size=fit.state.coefficients.shape)
    return State(fit.state.coefficients + noise, fit.state.values)


@pytest.mark.long
def test_a_pace_is_where_nothing_else_in_it_costs_less(fit):
    state = with_centre_velocity(fit.model, disturbed(fit))
    best, own = cost(fit, state), fit.model.tracks.columns("velocity")
    rng = np.random.default_rng(5)
    for _ in range(5):
        there = state.coefficients.copy()
        there[:, own] += rng.normal(scale=1e-3, size=there[:, own].shape)
        assert cost(fit, State(there, state.values)) > best


def test_a_step_gains_what_it_promises_once_the_pace_has_followed(fit):
    begun = with_centre_velocity(fit.model, disturbed(fit, 1e-3))
    step = Step.of(fit.model, all_rows(fit.model, begun, fit.noise, fit.anchor))
    whole = moved(fit.model, begun, step.splines, step.values)
    gained = cost(fit, begun) - cost(fit, with_centre_velocity(fit.model, whole))
    assert gained == pytest.approx(step.promised, rel=0.01)


def test_a_fit_that_is_begun_elsewhere_comes_to_the_same_cost(fit):
    again = solve(fit.model, disturbed(fit, 0.005), fit.noise, fit.anchor)
    count = sum(r.residual.value.size for r in fit.measured)
    assert again.cost == pytest.approx(fit.cost, abs=SOLVER.least_gain * count)  # 1 nat


def test_columns_that_begin_at_a_moment_promise_what_those_cut_off_by_hand_do(fit):
    base, rng, prior = Base.of(fit), np.random.default_rng(6), np.array([1.0, 2.0])
    groups = [r for r in fit.measured if r.name.startswith("imu1.")]
    columns = {r.name: rng.normal(size=(*r.residual.value.shape, 2)) for r in groups}
    after, knots = After.of(base, columns), fit.model.tracks.knots
    for moment in (1.0, 4.503, 7.2):
        edge = np.floor((moment - knots.start) / knots.step) * knots.step + knots.start
        cut = [(r.name, columns[r.name] * (r.time >= edge)[:, None, None]) for r in groups]
        exact = promise(*base.reduced(cut, 2), prior).evidence
        assert after.promises(np.array([moment]), prior)[0] == pytest.approx(exact, rel=1e-6, abs=1e-6)


def test_a_column_that_the_fit_has_already_promises_nothing(fit):
    """However far the fit is from its best: a copy of a parameter gains what the parameter itself would."""
    state = State(
        fit.state.coefficients, fit.state.values | {"imu1.rotation": fit.state.values["imu1.rotation"] + 0.003}
    )
    rows = all_rows(fit.model, state, fit.noise, fit.anchor)
    base = Base.of(solve(fit.model, state, fit.noise, fit.anchor, steps=0))
    own = fit.model.parameters.columns("imu1.rotation")
    copies = [(r.name, base.parts[r.name].border[:, :, own]) for r in rows if not r.name.startswith("prior.")]
    information, gradient = base.reduced(copies, 3)
    assert promise(information, gradient, np.full(3, 0.01)).gain < 1.0
    pull = sum(np.einsum("nmk,nm->k", c, base.parts[n].residual) for n, c in copies)
    assert 0.5 * float(pull @ pull) * 0.01**2 > 10.0  # which alone would promise much


def test_columns_that_begin_after_the_last_sample_promise_nothing(fit):
    columns = {"imu1.gyro": np.ones((*fit.measured[0].residual.value.shape, 2))}
    end = fit.model.tracks.knots.start + fit.model.tracks.knots.step * fit.model.tracks.knots.count
    assert After.of(Base.of(fit), columns).promises(end + np.array([-0.05, 0.0, 1.0]), np.ones(2)) == [0.0] * 3
