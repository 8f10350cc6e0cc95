"""Rounding that noise does not blur is regular, and a state that gains no more than that goes."""

import numpy as np
import pytest

from imubench.diagnosis.criteria.trial import Gain, Kept
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.diagnosis.search.rounding import ROUNDED, RoundedStates, roundings, sharp
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case
from tests.searching import moved

PIVOT = Hypothesis(EFFECTS["moving_pivot"], "joint")
BIAS = Hypothesis(EFFECTS["gyro_bias"], "imu1")


@pytest.fixture(scope="module")
def lone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lone")
    make_case(folder / "r", "pendulum", [], 5, seconds=6.0)
    return read(folder / "r")[0]


def rounded_to(step, unit="m/s^2"):
    size = Parameter(np.array(step), np.array(0.0), unit)
    return [Finding("quantisation", "imu1", 0.99, {"step": size}, Interval(0.0, (0.0, 0.0)))]


def test_noise_blurs_steps_as_the_average_over_it_says(lone):
    """The regular error of a reading x that is rounded is (d / pi) sin(2 pi x / d) first of all; noise averages it."""
    std, step = lone.imus[0].accel_noise_std, 3.0 * lone.imus[0].accel_noise_std
    noise = std * np.random.default_rng(1).standard_normal(400_000)
    x = np.linspace(0, step, 25, endpoint=False)
    error = [np.mean(step * np.round((a + noise) / step) - a - noise) for a in x]
    wave = -np.sin(2 * np.pi * x / step)
    left = 2 * np.mean(error * wave) / (step / np.pi)
    assert roundings(rounded_to(step), lone)["imu1"].regular == pytest.approx(left, abs=0.01)


def test_a_lone_rounded_imu_is_the_joint_too_and_a_gyroscope_has_no_hum(lone):
    found = roundings(rounded_to(0.3), lone)
    assert found.keys() == {"imu1", "joint"}
    assert (found["imu1"].hum, found["joint"].hum) == (pytest.approx(0.3 / np.pi), 0.0)
    assert roundings(rounded_to(0.03, "rad/s"), lone)["imu1"].hum == 0.0
    assert sharp(rounded_to(10 * lone.imus[0].accel_noise_std), lone) == dict.fromkeys(
        ("imu1", "joint"), ROUNDED * lone.imus[0].accel.size
    )
    assert sharp(rounded_to(lone.imus[0].accel_noise_std), lone) == {}


@pytest.mark.long
def test_a_state_that_gains_no_more_than_rounding_goes_and_what_has_none_stays(lone):
    fit = refit(nominal_fit(lone), (PIVOT, BIAS))
    kept = [
        Kept(h, 50.0, Gain(gain, gain - 10.0, gain + 10.0, np.ones(3)), ())
        for h, gain in ((PIVOT, 400.0), (BIAS, 40.0))
    ]
    less = moved(RoundedStates(), fit, kept, rounding={"joint": 900.0, "imu1": 900.0})
    assert ([k.hypothesis for k in less.kept], less.dropped) == ([BIAS], ((PIVOT, 400.0),))
    assert less.fit.model.hypotheses == (BIAS,)
    for enough in ({"joint": 300.0}, {"imu1": 900.0}, {}):
        same = moved(RoundedStates(), fit, kept, rounding=enough)
        assert same.fit is fit and list(same.kept) == kept and not same.dropped
