"""A fit that numbers are read off ends in one place, wherever its search began."""

import numpy as np
import pytest

from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.solve.levenberg_marquardt import converged, solve
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

SLIDING = Hypothesis(EFFECTS["skin_sliding"], "imu1")


@pytest.fixture(scope="module")
def sliding(tmp_path_factory):
    """A pendulum whose sensor slides: its mount, its slide and its twist move together at next to no cost."""
    folder = tmp_path_factory.mktemp("sliding") / "case"
    make_case(folder, rig="pendulum", effects=[("skin_sliding", "imu1")], seed=7, seconds=10.0)
    return refit(nominal_fit(read(folder)[0]), (SLIDING,))


def off(fit, std):
    """A search that begins with the mount and the slide a standard deviation off."""
    values = {n: v + std[n] * (-1.0) ** np.arange(v.size) for n, v in fit.state.values.items()}
    return solve(fit.model, State(fit.state.coefficients, values), fit.noise, fit.anchor)


@pytest.mark.long
def test_it_ends_where_it_ends_from_elsewhere(sliding):
    std = parameter_std(sliding)
    ends = [converged(sliding), converged(off(sliding, std))]
    numbers = sum(r.residual.value.size for r in ends[0].measured)
    assert ends[0].cost == pytest.approx(ends[1].cost, abs=10 * SOLVER.fine_gain * numbers)
    for name in (SLIDING.key("slide"), SLIDING.key("twist"), "imu1.rotation"):
        apart = np.abs(ends[0].state.values[name] - ends[1].state.values[name]) / std[name]
        assert apart.max() < 0.1, (name, apart)


@pytest.mark.long
def test_a_search_alone_does_not(sliding):
    """What it is for: the same start, not converged, ends elsewhere."""
    std = parameter_std(sliding)
    end, other = converged(sliding), off(sliding, std)
    apart = np.abs(end.state.values[SLIDING.key("twist")] - other.state.values[SLIDING.key("twist")])
    assert (apart / std[SLIDING.key("twist")]).max() > 0.3
    assert end.cost < other.cost


def test_what_is_converged_stays(sliding):
    """But for some steps of the size at which a search ends: it ends with one, and more of them may follow."""
    end = converged(sliding)
    again = converged(end)
    numbers = sum(r.residual.value.size for r in end.measured)
    assert end.cost <= sliding.cost
    assert again.cost == pytest.approx(end.cost, abs=10 * SOLVER.fine_gain * numbers)
