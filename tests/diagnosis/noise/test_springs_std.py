"""How surely springs are known: the interval of what they could be, on closed forms and on unseen recordings."""

from types import SimpleNamespace

import numpy as np
import pytest

import imubench.diagnosis.noise.intervals as module
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.noise.debiased_fit import debiased
from imubench.diagnosis.noise.intervals import with_spring_intervals
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.add_dynamic import state_trials
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

ROCKING = Hypothesis(EFFECTS["rocking_mount"], "imu2")
DAMPING, FREQUENCY = (ROCKING.key(name) for name in ("damping_ratio", "frequency"))


def told(monkeypatch, damping, scatter, costs=lambda value: 0.0):
    """What is said of dampings (3,) that fits hold for known within scatter(z), at a cost of costs(z)."""
    numbers = {FREQUENCY: np.full(3, 9.0), DAMPING: np.asarray(damping)}
    numbers |= {ROCKING.key(name): np.ones(3) for name in ("com", "lever")}

    def fit_of(key, value):
        values = {k: np.log(v) for k, v in (numbers | {key: np.asarray(value)}).items()}
        model = SimpleNamespace(hypotheses=[ROCKING])
        return SimpleNamespace(model=model, state=SimpleNamespace(values=values), cost=costs(np.max(value)))

    def std_of(fit):
        z = np.exp(fit.state.values[DAMPING])
        return {FREQUENCY: np.full(3, 0.01), DAMPING: scatter(z) / z} | {
            ROCKING.key(name): np.full(3, 0.1) for name in ("com", "lever")
        }

    monkeypatch.setattr(module, "held_at", lambda fit, key, value: fit_of(key, value))
    monkeypatch.setattr(module, "parameter_std", std_of)
    fit = fit_of(DAMPING, damping)
    return std_of(fit)[DAMPING] * damping, with_spring_intervals(fit, std_of(fit))[DAMPING] * damping


def test_where_a_damping_is_known_as_well_whatever_it_is_the_interval_is_the_usual_one(monkeypatch):
    before, after = told(monkeypatch, np.array([0.05, 0.1, 0.2]), lambda z: np.full(3, 0.02))
    np.testing.assert_allclose(after, before, rtol=1e-9)


def test_where_larger_dampings_are_less_known_it_reaches_as_far_as_they_scatter(monkeypatch):
    """s(z) = 0.01 + 0.4 z: z' - z = 1.96 s(z') at z' = (z + 0.0196) / (1 - 0.784)."""
    z = np.array([0.02, 0.04, 0.08])
    before, after = told(monkeypatch, z, lambda x: 0.01 + 0.4 * x)
    end = (z + 0.01 * STATISTICS.interval_sigmas) / (1 - 0.4 * STATISTICS.interval_sigmas)
    np.testing.assert_allclose(after, (end - z) / STATISTICS.interval_sigmas, rtol=1e-6)  # straight in between
    assert (after > 1.5 * before).all()


def test_what_costs_much_is_not_in_it(monkeypatch):
    z = np.array([0.02, 0.04, 0.08])
    before, after = told(monkeypatch, z, lambda x: 0.01 + 0.4 * x, lambda x: 100.0 * (x > 0.09))
    np.testing.assert_allclose(after, before, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "pulled"), [(2, [False, True, False]), (11, [False, False, False])])
def test_springs_that_hardly_ring_have_dampings_that_are_hardly_known(tmp_path, seed, pulled):
    """One damping of 0.22 is 0.02 by noise, nine of the usual deviations off; better known ones stay so."""
    rng = np.random.default_rng(seed)
    asked = {"frequency": rng.uniform(16, 24, 3), "damping_ratio": rng.uniform(0.1, 0.3, 3)}
    asked |= {"com": rng.uniform(-0.002, 0.002, 3), "lever": np.zeros(3)}
    options = {"seconds": 10.0, "rate": 100.0, "rate2": 100.0, "band": 2.5}
    truth = make_case(tmp_path / "r", "hinge", [("rocking_mount", "imu2", asked)], seed, **options)
    (best, *_) = state_trials(nominal_fit(read(tmp_path / "r")[0]), [ROCKING], lambda _: None)
    fit = debiased(with_noise(best.fit, 4))
    usual, found = parameter_std(fit), with_spring_intervals(fit, parameter_std(fit))
    off = np.log(truth["effects"][0]["parameters"]["damping_ratio"]) - fit.state.values[DAMPING]
    linear = np.expm1(off)  # of the damping that was found
    assert list(np.abs(linear) > 4 * usual[DAMPING]) == pulled
    assert (np.abs(linear) < 2.2 * found[DAMPING]).all()
    if not any(pulled):
        np.testing.assert_allclose(found[DAMPING], usual[DAMPING])
