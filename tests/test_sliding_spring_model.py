"""An r that hangs on a spring: its motion and its derivatives."""

import numpy as np
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from imubench.estimators import sliding_spring
from imubench.estimators.sliding_spring_model import Oscillators, SpringModel
from tests.swinging_limb import RATE, sprung


def test_an_oscillator_does_what_the_solution_says():
    step, m, z = 0.01, 2 * np.pi * 3, 0.2
    t = np.arange(300) * step
    springs = Oscillators(np.full(3, m), z, np.zeros((300, 3, 6)), step)
    state = springs.under(np.tile(5 + 2 * t, (3, 1)).T[..., None], np.repeat([0.1, 0.3], 3)[:, None])[..., 0]
    found = solve_ivp(
        lambda s, y: [y[1], 5 + 2 * s - 2 * z * m * y[1] - m**2 * y[0]],
        (0, t[-1]),
        [0.1, 0.3],
        t_eval=t,
        rtol=1e-10,
        atol=1e-13,
    )
    assert_allclose(state[:, 0], found.y[0], atol=1e-9)  # exact for a straight u; the integration has 1e-10
    assert_allclose(state[:, 3], found.y[1], atol=1e-8)


def test_derivatives_of_the_spring():
    rows, _ = sprung(3.7, 0.2, duration=3.0)
    model = SpringModel(rows)
    p = sliding_spring.MEAN + sliding_spring.STD * np.random.default_rng(1).normal(size=21) * 0.3
    moved = model.moved(p)
    for i in range(21):
        h = 1e-3 * sliding_spring.STD * (np.arange(21) == i)
        later, earlier = model.moved(p + h), model.moved(p - h)
        for ours, two, straight in (
            (moved.r_by()[..., i], (later.r, earlier.r), 0.01),
            (moved.by[:, i], (later.predicted, earlier.predicted), 0.02),
        ):
            numbers = (two[0] - two[1]) / (2 * h[i])
            # m and z: forces between samples are taken as straight, which is an error of (m step)^2 / 12 = 0.5 %, and
            # of twice that in the rows, which hold r'
            assert np.abs(ours - numbers).max() / np.abs(numbers).max() < (straight if 3 <= i <= 6 else 1e-6)


def test_the_springs_r_makes_the_rows_that_any_r_makes():
    rows, _ = sprung(3.7, 0.2, duration=3.0)
    p = sliding_spring.MEAN + 0.2 * sliding_spring.STD * (np.arange(21) < 12)
    moved = SpringModel(rows).moved(p)
    numbers = np.gradient(moved.r, 1 / RATE, axis=0, edge_order=2)
    of_any = rows.predicted(moved.r[..., None], numbers[..., None])[:, 0]
    # (2 pi 5 Hz step)^2 / 6 = 2 % of r', by the differences
    assert np.abs(moved.predicted - of_any).max() < 0.03 * np.abs(of_any).max()
