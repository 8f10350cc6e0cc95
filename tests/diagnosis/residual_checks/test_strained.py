"""Numbers that no sensor has say that another law is at work: names that have them are doubted."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks.implausible import implausible_places
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

SCALE, BIAS = Hypothesis(EFFECTS["gyro_scale"], "imu2"), Hypothesis(EFFECTS["gyro_bias"], "imu1")


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("strained") / "case"
    asked = [("gyro_scale", "imu2", {"scale": [0.02, -0.03, 0.02]}), ("gyro_bias", "imu1", {"bias": [0.01, 0.0, 0.02]})]
    make_case(folder, rig="hinge", effects=asked, seed=5, seconds=5.0, rate=50.0)
    return refit(nominal_fit(read(folder)[0]), (SCALE, BIAS))


def at(fit, scale):
    """The fit, its gyroscope's scales elsewhere."""
    values = fit.state.values | {SCALE.key("scale"): np.array(scale)}
    return replace(fit, state=replace(fit.state, values=values))


def test_a_sensor_s_numbers_strain_nothing(fit):
    assert implausible_places(fit) == set()


def test_a_gyroscope_that_reads_a_fraction_is_none(fit):
    assert implausible_places(at(fit, [-0.89, 0.22, -0.13])) == {"imu2"}


def test_a_number_that_nothing_beside_makes_up_for_may_be_larger(fit):
    other = Hypothesis(EFFECTS["gyro_bias"], "imu2")
    both = refit(fit, (SCALE, BIAS, other))
    odd = [0.31, -0.22, -0.22]
    assert implausible_places(at(fit, odd)) == set() and implausible_places(at(both, odd)) == {"imu2"}
