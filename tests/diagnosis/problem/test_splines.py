"""The diagnosis' splines against SciPy's."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import BSpline

from imubench.diagnosis.problem.bspline import DEGREE, Knots, Moment, Tracks
from imubench.jets import CONSTANT, Jet


@pytest.mark.parametrize("order", range(5))
def test_values_and_derivatives_are_scipys(order):
    knots = Knots.over(2.0, 3.0, 0.05)
    rng = np.random.default_rng(0)
    coefficients = rng.normal(size=(knots.count, 4))
    time = np.sort(rng.uniform(2.0, 3.0, 40))
    tracks = Tracks(knots, {"a": 1, "b": 3})
    moment = Moment(tracks, coefficients, Jet(time[:, None]))
    places = knots.start + knots.step * (np.arange(knots.count + DEGREE + 1) - DEGREE)
    scipy = BSpline(places, coefficients[:, 1:], DEGREE).derivative(order)
    scale = knots.step**-order
    assert_allclose(moment.track("b", order).value, scipy(time), atol=1e-11 * scale)  # rounding


def test_a_clock_enters_through_the_slope():
    knots = Knots.over(0.0, 1.0, 0.05)
    coefficients = np.random.default_rng(1).normal(size=(knots.count, 2))
    tracks = Tracks(knots, {"a": 2})
    time = np.linspace(0.1, 0.9, 7)[:, None]
    clock = ("clock", CONSTANT)
    jet = Moment(tracks, coefficients, Jet(time, {clock: np.ones((1, 1, 1))})).track("a", 1)
    ends = [Moment(tracks, coefficients, Jet(time + s * 1e-7)).track("a", 1).value for s in (1, -1)]
    assert_allclose(jet.blocks[clock][:, :, 0], (ends[0] - ends[1]) / 2e-7, rtol=1e-4, atol=1e-2)  # its error


@pytest.mark.parametrize("seconds", [5.0, 70.0])
def test_samples_of_a_clock_that_ticks_with_the_knots_share_their_place(seconds):
    """Their step is read off the stamps, as a fit's is; and a clock that goes a part in a million slower drifts."""
    stamps = np.round(0.025 * np.arange(seconds * 40), 9)
    knots = Knots.over(-0.2, seconds + 0.2, float(np.median(np.diff(stamps))))
    phase = knots.phase(stamps)
    assert phase is not None
    for order in range(3):
        _, weights = knots.weights(stamps, order)
        assert_allclose(
            weights, np.tile(knots.weights_at(phase, order), (len(stamps), 1)), rtol=0, atol=1e-8 * weights.max()
        )
    assert knots.phase(stamps * (1 - 1e-6)) is None
