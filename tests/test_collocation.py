"""A spring's law held once an interval of a spline, against the spring in continuous time."""

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.optimize import least_squares

from imubench.effects import EFFECTS
from imubench.effects.collocation import collocated, in_time

FREQUENCIES = np.array([3.0, 8.0, 12.5, 16.0])
STEPS = (1 / 40, 1 / 100)


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_a_wave_of_the_springs_frequency_obeys_the_collocated_law(frequency, step):
    """Without damping: a spline with coefficients exp(i v h j) says the same in the middle of every interval."""
    turn = 2j * np.pi * frequency * step
    coefficients = np.exp(turn * np.arange(34))
    x = BSpline(step * np.arange(40), np.stack([coefficients.real, coefficients.imag], axis=1), 5)
    middle = step * (np.arange(5, 34) + 0.5)
    values = x(middle) @ [1, 1j]
    np.testing.assert_allclose(values[1:] / values[:-1], np.exp(turn), rtol=1e-9)  # it rings so: rounding
    w = 2 * np.pi * float(collocated(np.array([frequency]), step)[0])
    law = x.derivative(2)(middle) + w * w * x(middle)
    assert np.max(np.abs(law @ [1, 1j] / (w * w * values))) < 1e-9  # rounding


@pytest.mark.parametrize("step", STEPS)
def test_there_and_back(step):
    np.testing.assert_allclose(in_time(collocated(FREQUENCIES, step), step), FREQUENCIES, rtol=1e-9)  # 60 rounds


def test_many_knots_a_period_change_nothing_and_too_few_say_nothing():
    few = np.array([5.0])
    np.testing.assert_allclose(collocated(few, 1e-3), few, rtol=1e-6)  # 200 knots a period
    for way in (in_time, collocated):
        assert way(np.array([30.0]), 1 / 40) == 30.0  # it only gives way
    assert in_time(np.array([16.2]), 1 / 40) == 40 / 2.35  # of the fewest knots a period that tell a spring


def test_only_a_springs_frequency_is_told_otherwise():
    law = EFFECTS["rocking_mount"]
    values = {"frequency": np.log([8.0, 10.0, 12.0]), "damping_ratio": np.log([0.05] * 3), "com": np.ones(3)}
    told = law.in_time(values, 1 / 40)
    assert np.all(told["frequency"] > values["frequency"])
    assert told["damping_ratio"] is values["damping_ratio"] and told["com"] is values["com"]
    back = law.collocated(told, 1 / 40)["frequency"]
    np.testing.assert_allclose(back, values["frequency"], rtol=1e-9)
    assert EFFECTS["low_pass"].in_time(values, 1 / 40) is values


def ratio(order, frequency, step):
    """A spline's derivative over its value (n,) in the middle of an interval, of waves of these frequencies."""
    basis, places = BSpline.basis_element(np.arange(7.0)), 0.5 + np.arange(6)
    waves = np.exp(-2j * np.pi * step * np.outer(frequency, np.arange(6)))
    return (waves @ basis.derivative(order)(places)) / (waves @ basis(places)) / step**order


@pytest.mark.parametrize("damping", [0.03, 0.05, 0.1])
@pytest.mark.parametrize(("frequency", "step"), [(10.0, 1 / 40), (12.5, 1 / 40), (18.0, 1 / 100)])
def test_a_driven_spring_is_found_as_it_is(frequency, step, damping):
    """The response to a known drive up to half beyond the resonance is fitted with that of the collocated law."""
    w = 2 * np.pi * frequency
    tones = np.linspace(1.0, 1.5 * frequency, 400)
    v = 2 * np.pi * tones
    true = 1j * v / (w * w - v * v + 2j * damping * w * v)  # rate, of a drive of 1 rad/s^2
    first, second = (ratio(order, tones, step) for order in (1, 2))

    def off(p):
        u, z = np.exp(p)
        found = first / (u * u + second + 2 * z * u * first) - true
        return np.concatenate([found.real, found.imag]) / np.max(np.abs(true))

    fitted = np.exp(least_squares(off, np.log([0.99 * w, damping]), x_scale=[1e-3, 1e-2]).x)
    raw = fitted[0] / (2 * np.pi)
    told = float(in_time(np.array([raw]), step)[0])
    # What drives it beside its resonance has another error, the more the wider that is: less than half is left.
    assert abs(told / frequency - 1) < 0.5 * abs(raw / frequency - 1)
    assert fitted[1] == pytest.approx(damping, rel=0.15)  # 13 % at 3.2 knots a period, where the resonance is widest
