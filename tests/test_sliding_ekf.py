"""The filters of an r that slides: derivatives, what a bank of them follows, and that it is the filters one by one."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.errors import InputError
from imubench.estimators import sliding_ekf
from tests.swinging_limb import BIG, recorded, slide


@pytest.mark.parametrize("part", ["predicted", "measured"])
def test_derivatives_of_the_filter(part):
    x = np.random.default_rng(2).normal(size=sliding_ekf.STATES)
    step = {"predicted": lambda y: sliding_ekf.predicted(y, 0.013), "measured": sliding_ekf.measured}[part]
    h = 1e-6 * np.eye(x.size)
    numbers = np.stack([(step(x + e)[0] - step(x - e)[0]) / 2e-6 for e in h], axis=1)
    assert_allclose(step(x)[1], numbers, atol=1e-7)  # rounding over 1e-6, and its square


def test_a_filter_bank_follows_a_fast_slide():
    rows, r = recorded(lambda t: slide(t, (BIG[0], 2.7, 0.0)), seed=6, duration=6.0)
    bank = sliding_ekf.SlidingBank()
    found = np.array([bank.update(w, a, 0.01) for w, a in zip(rows.gyro, rows.accel - rows.up, strict=True)])
    assert np.linalg.norm(found - r, axis=1)[400:].mean() < 0.01  # m, what is asked of a stream; 4.7 mm after 4 to 6 s
    with pytest.raises(InputError, match=r"sliding filter: expected a time step > 0 s, got -1\.0"):
        bank.update(rows.gyro[0], rows.accel[0], -1.0)


def test_filters_side_by_side_are_the_filters_one_by_one():
    rows, _ = recorded(lambda t: slide(t, (BIG[0], 2.7, 0.0)), seed=6, duration=1.0)
    starts = (0.5, 2.0)
    bank, alone = sliding_ekf.SlidingBank(starts), [sliding_ekf.SlidingFilter(f) for f in starts]
    for w, a in zip(rows.gyro, rows.accel - rows.up, strict=True):
        bank.update(w, a, 0.01)
        for one in alone:
            one.update(w, a, 0.01)
    for i, one in enumerate(alone):
        assert_allclose(one.x[0], bank.x[i], rtol=1e-9)  # rounding
        assert one.log_likelihood[0] == pytest.approx(bank.log_likelihood[i], rel=1e-9)
    best = int(np.argmax(bank.log_likelihood))
    assert_allclose(bank.update(w, a, 0.01), alone[best].update(w, a, 0.01), rtol=1e-9)
