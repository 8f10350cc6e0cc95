"""What `sliding` is instead of, the smoother and the filter of an r of any shape, and cases by chance."""

import numpy as np
from numpy.testing import assert_allclose

from benchmarks.sliding_chance import drawn, judged
from benchmarks.sliding_shapes import chosen, filtered, measuring, smoothed
from imubench.estimators import sliding_search
from imubench.reproduce.arve.runs import removed
from imubench.reproduce.arve.soft_runs import NOISE, Cell, recorded, rows_of, truth_of


def off(r, true):
    return 1e3 * np.linalg.norm(r - true, axis=1).mean()


def test_the_measurement_is_what_the_simulator_feels():
    truth = truth_of(Cell("sliding", 0.02, 0.7))
    runs = recorded(truth, 0)
    t, w, r = runs.time, truth.gyro, truth.joint_vector
    first, second, dw = (np.gradient(x, t, axis=0, edge_order=2) for x in (r, np.gradient(r, t, axis=0), w))
    H = measuring(w, dw, True)
    a = removed(runs, "known")[0] - (runs.accel[0] - truth.specific_force)
    found = np.einsum("nij,nj->ni", H, np.hstack([r, first, second]))
    assert_allclose(found[5:-5], a[5:-5], atol=0.03)  # m/s^2 of 3; (2 pi Hz step)^2 / 6 of w' and r''


def test_the_filter_ends_where_least_squares_does():
    rng = np.random.default_rng(0)
    H, F, P = rng.normal(size=(30, 3, 4)), np.linalg.qr(rng.normal(size=(4, 4)))[0], np.diag([1.0, 2.0, 3.0, 4.0])
    a = rng.normal(size=(30, 3))
    powers = [np.linalg.matrix_power(F, k + 1) for k in range(30)]
    A = np.concatenate([h @ p for h, p in zip(H, powers, strict=True)])
    x = np.linalg.solve(A.T @ A / NOISE[1] ** 2 + np.linalg.inv(P), A.T @ a.ravel() / NOISE[1] ** 2)
    r = filtered(a, H, 0.01, F, np.zeros((4, 4)), P)[1]
    assert_allclose(r[-1], (powers[-1] @ x)[:3], atol=1e-8)  # thirty updates of a condition of 1e4


def test_a_spline_explains_a_slide_at_the_swings_frequency_and_is_far_off():
    runs = recorded(truth_of(Cell("sliding", 0.02, 1.0)), 0)
    rows = rows_of(runs, removed(runs, "known"))
    weight, r = smoothed(rows, True)
    assert off(r, runs.r) > 20  # 58 mm: R(t)^T c is a spline, too
    ours = sliding_search.fit(rows, True)
    assert ours.evidence > weight + 100  # nat
    assert off(ours.r(rows.time)[0], runs.r) < 1  # mm


def test_a_spline_follows_what_is_not_felt():
    runs = recorded(truth_of(Cell("paper", 0.02, 0.3)), 0)
    rows = rows_of(runs, removed(runs, "known"))
    assert off(chosen(lambda felt: smoothed(rows, felt)), runs.r) < 1.5  # mm; 0.8 measured


def test_a_drawn_slide_is_found_and_judged():
    cell = drawn("sliding", 0)
    assert 0.3 <= cell.frequency <= 5.0
    filtered, ours, mean, _, right, stream, _ = judged(cell, False)
    assert right == 1.0
    assert mean <= ours < 0.5  # mm; 0.28 is the worst of 24
    assert filtered > 20  # a felt slide
    assert np.isnan(stream)
