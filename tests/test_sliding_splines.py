"""Angular rates smoothed by splines."""

import numpy as np

from imubench.estimators.sliding_splines import smoothed
from tests.swinging_limb import NOISE, first_difference, rates, recorded, slide


def test_the_smoothed_rate_is_nearer_to_the_truth_than_the_gyroscope():
    rows, _ = recorded(lambda t: slide(t), seed=3)
    spline, true = smoothed(rows.time, rows.gyro).spline, rates(rows.time)
    assert np.std(spline(rows.time) - true) < 0.4 * NOISE[0]  # 0.25 measured
    second = first_difference(lambda t: first_difference(rates, t), rows.time)
    assert np.std((spline(rows.time, 2) - second)[50:-50]) < 0.02 * np.std(second)  # at the ends it is free
