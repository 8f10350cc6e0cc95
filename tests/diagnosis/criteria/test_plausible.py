"""Springs whose numbers no sensor on a limb has: their law stands for something else."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.criteria.plausible_fit import holds_its_law, plausible
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.nominal import first_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.initialize import model_of
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

ROCKING = Hypothesis(EFFECTS["rocking_mount"], "imu2")


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plausible") / "r"
    make_case(folder, "hinge", [], 5, seconds=4.0, rate=50.0)
    return extended(first_fit(model_of(read(folder)[0]), 1), (ROCKING,))


@pytest.mark.parametrize(
    ("name", "metres", "can_be"),
    [
        ("lever", 0.03, True),  # as far as a sensor's own foam reaches
        ("lever", 0.2, False),  # a pivot in the next limb
        ("com", 0.006, True),  # the battery on one side
        ("com", 0.026, False),  # beyond the body
    ],
)
def test_a_sensor_turns_about_a_place_near_it_and_its_weight_is_in_it(fit, name, metres, can_be):
    values = fit.state.values | {ROCKING.key(name): np.array([0.0, metres, 0.0])}
    told = replace(fit, state=replace(fit.state, values=values))
    assert plausible(told, ROCKING) is can_be
    if not can_be:
        assert not holds_its_law(Trial(ROCKING, told, 100.0))
