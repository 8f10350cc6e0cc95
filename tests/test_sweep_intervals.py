"""Quantiles and shares of few recordings, and their intervals, beside textbooks and beside chance."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from imubench.sweeps.intervals import quantile, quantile_interval, share_interval


@given(arrays(float, st.integers(1, 30), elements=st.floats(0, 1e6)), st.floats(0, 1))
def test_a_quantile_of_numbers_is_numpy_s(errors, q):
    assert quantile(errors, q) == pytest.approx(np.quantile(errors, q), rel=1e-9, abs=1e-9)  # rounding of 30 numbers


def test_no_answer_counts_as_an_infinite_error():
    assert quantile(np.array([1.0, 2.0, np.inf]), 0.5) == 2.0
    assert quantile(np.array([1.0, 2.0, np.inf, np.inf]), 0.5) == np.inf
    assert np.isnan(quantile(np.array([]), 0.5))


def test_the_interval_of_the_median_of_twenty_is_the_sixth_and_the_fifteenth():
    """Table of David and Nagaraja: 95.9 % of a median's intervals of n = 20 from the 6th to the 15th hold it."""
    assert quantile_interval(np.arange(1.0, 21.0), 0.5) == (6.0, 15.0)


def test_an_interval_without_an_end_is_open():
    assert quantile_interval(np.arange(1.0, 5.0), 0.5) == (0.0, np.inf)  # 2^-4 beyond either end is more than 2.5 %
    assert quantile_interval(np.arange(1.0, 21.0), 0.95)[1] == np.inf  # 0.95^20 is 36 %
    assert quantile_interval(np.array([]), 0.5) == (0.0, np.inf)


@pytest.mark.parametrize("q", (0.25, 0.5, 0.75))
def test_intervals_hold_the_quantile_as_often_as_they_say(q):
    rng = np.random.default_rng(0)
    truth = -np.log(1 - q)  # of an exponential law
    held = [low <= truth <= high for low, high in (quantile_interval(rng.exponential(size=20), q) for _ in range(3000))]
    assert np.mean(held) > 0.95 - 0.012  # three standard deviations of 3000 draws; discrete ends hold more


def test_intervals_of_shares_are_clopper_and_pearson_s():
    assert share_interval(0, 10) == pytest.approx((0.0, 1 - 0.025**0.1), abs=1e-12)  # the closed form
    assert share_interval(5, 10) == pytest.approx((0.1871, 0.8129), abs=1e-4)  # Newcombe 1998, table
    assert share_interval(10, 10)[1] == 1.0
    assert share_interval(0, 0) == (0.0, 1.0)
