"""An effect of many numbers takes another's place only where no two of few are worth more."""

import numpy as np
import pytest

from imubench.diagnosis.criteria.trial import Gain, Kept, Passed
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.swap_for_rival import RivalForEffect, beside
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.refit import evidence_over, refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case
from tests.searching import moved

BIAS, DRIFT, MATRIX, GRAVITY = (
    Hypothesis(EFFECTS[name], at)
    for name, at in (
        ("gyro_bias", "imu1"), ("gyro_drift", "imu1"), ("g_sensitivity", "imu1"), ("gravity", "world"),
    )
)  # fmt: skip


def fit_of(folder, asked, seed=7):
    make_case(folder / "r", "pendulum", asked, seed, seconds=10.0, rate=50.0)
    return refit(nominal_fit(read(folder / "r")[0]), (BIAS, GRAVITY))


def chosen(fit):
    """The names after an exchange in which the nine numbers tie with the bias that came first."""
    gain = Gain(500.0, 400.0, 600.0, np.full(4, 125.0))
    first = Kept(BIAS, 500.0, gain, (Passed(MATRIX, 495.0),))
    kept = [first, Kept(GRAVITY, 500.0, gain, ())]
    state = moved(RivalForEffect(), fit, kept, everything=tuple(candidates(fit.model)))
    return [k.hypothesis.effect.name for k in state.kept]


GIVEN = [("gyro_bias", "imu1", {"bias": [0.01, -0.02, 0.015]}), ("gravity", "world", {"g": 9.75})]
DRIFTS = ("gyro_drift", "imu1", {"rate": [0.002, 0.0015, -0.0025]})
SENSES = ("g_sensitivity", "imu1", {"matrix": [[0.001, -0.004, 0.001], [0.003, 0.001, -0.002], [0.002, 0.002, 0.003]]})


@pytest.mark.parametrize(
    ("asked", "expected"), [([*GIVEN, DRIFTS], "gyro_bias"), ([GIVEN[1], SENSES], "g_sensitivity")]
)
def test_nine_numbers_are_held_against_three_and_three(tmp_path, asked, expected):
    fit = fit_of(tmp_path, asked)
    swapped = refit(fit, (MATRIX, GRAVITY))
    assert evidence_over(fit, swapped) > 5  # either way they are worth more than the bias alone
    assert chosen(fit) == [expected, "gravity"]


def test_what_stands_beside_has_no_more_numbers_than_asked(tmp_path):
    fit = fit_of(tmp_path, [*GIVEN, DRIFTS])
    drift = evidence_over(fit, refit(fit, (*fit.model.hypotheses, DRIFT)))
    assert MATRIX.effect.numbers - BIAS.effect.numbers == 6
    assert beside(fit, 6, candidates(fit.model), lambda _: None) == pytest.approx(drift, rel=0.01)
    assert beside(fit, 2, candidates(fit.model), lambda _: None) < 0.5 * drift
    assert beside(fit, 0, candidates(fit.model), lambda _: None) == 0
