"""A spring's law held once an interval of a spline, against the spring in continuous time."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.verdict.findings import parameters
from imubench.effects import EFFECTS
from imubench.effects.collocation import collocated, in_time, springs
from imubench.format1 import read
from imubench.proof.case import make_case

CASES = [(f, z, step) for f in (3.0, 8.0, 12.5, 16.0) for z in (0.01, 0.05, 0.3) for step in (1 / 40, 1 / 100)]


@pytest.mark.parametrize(("frequency", "damping", "step"), CASES)
def test_a_spline_that_rings_as_the_spring_obeys_the_collocated_law(frequency, damping, step):
    """Coefficients exp(s h j), s the spring's pole in time, make a spline of which every interval says the same."""
    w = 2 * np.pi * frequency
    pole = w * (-damping + 1j * np.sqrt(1 - damping**2))
    knots = step * np.arange(40)
    coefficients = np.exp(pole * step * np.arange(34))
    x = BSpline(knots, np.stack([coefficients.real, coefficients.imag], axis=1), 5)
    middle = knots[5:34] + step / 2
    values = x(middle) @ [1, 1j]
    np.testing.assert_allclose(values[1:] / values[:-1], np.exp(pole * step), rtol=1e-9)  # it rings so: rounding
    f, z = collocated(frequency, damping, step)
    v = 2 * np.pi * f
    law = x.derivative(2)(middle) + 2 * z * v * x.derivative(1)(middle) + v * v * x(middle)
    assert np.max(np.abs(law @ [1, 1j] / (v * v * values))) < 1e-9  # rounding


@pytest.mark.parametrize(("frequency", "damping", "step"), CASES)
def test_there_and_back(frequency, damping, step):
    there = collocated(frequency, damping, step)
    np.testing.assert_allclose(in_time(*there, step), (frequency, damping), rtol=1e-6)  # 30 rounds


def test_many_knots_a_period_change_nothing_and_too_few_say_nothing():
    f, z = collocated(5.0, 0.1, 1e-3)
    assert f == pytest.approx(5.0, rel=1e-6) and z == pytest.approx(0.1, rel=1e-6)  # 200 knots a period
    assert in_time(30.0, 0.1, 1 / 40) == (30.0, 0.1)
    assert in_time(5.0, 1.5, 1 / 40) == (5.0, 1.5)  # nothing rings


def test_one_damping_ratio_of_three_springs():
    values = {"frequency": np.log([8.0, 10.0, 12.0]), "damping_ratio": np.log([0.05]), "com": np.ones(3)}
    there = springs(values, 1 / 40, collocated)
    assert there["damping_ratio"].shape == (1,) and there["com"] is values["com"]
    back = springs(there, 1 / 40, in_time)
    np.testing.assert_allclose(
        np.exp(back["frequency"]), [8.0, 10.0, 12.0], rtol=5e-3
    )  # each has its own damping there


@pytest.mark.long
def test_springs_of_four_knots_a_period_are_found_as_they_are(tmp_path):
    """The generator integrates them finely; the fit has 50 knots a second."""
    true = {"frequency": [12.0, 13.0, 14.0], "damping_ratio": [0.06, 0.06, 0.06], "com": [0.004, 0.003, 0.005]}
    options = {"seconds": 8.0, "rate": 50.0, "vigour": 2.0, "band": 8.0, "rest": 0.0, "gyro_noise": 0.001}
    told = make_case(tmp_path / "r", "pendulum", [("rocking_mount", "imu1", true | {"lever": [0.0] * 3})], 3, **options)
    assert told["effects"][0]["parameters"]["frequency"] == true["frequency"]
    first = nominal_fit(read(tmp_path / "r")[0])
    h = Hypothesis(EFFECTS["rocking_mount"], "imu1")
    start = {h.key("frequency"): np.log(true["frequency"]), h.key("damping_ratio"): np.log(true["damping_ratio"])}
    fit = with_noise(refit(first, (h,), start))
    std = {h.key(p.name): np.zeros(p.width) for p in h.effect.parameters}
    found = parameters(h, fit, std)["frequency"].value
    raw = np.exp(fit.state.values[h.key("frequency")])
    assert np.max(np.abs(raw / true["frequency"] - 1)) > 0.01  # four knots a period: 0.6 to 1.5 % too low
    assert np.max(np.abs(found / true["frequency"] - 1)) < 0.005
