"""An r of oscillations: its derivatives, and the evidence of a linear model."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize_scalar
from scipy.stats import multivariate_normal

from imubench.estimators import sliding_lines


def test_derivatives_of_the_oscillations():
    t, f = np.linspace(0, 5, 40), np.array([0.7, 2.3])
    sizes = np.random.default_rng(0).normal(size=21)
    h = 1e-6

    def parts(q):
        r, rate = sliding_lines.design(t, q[21:], q[:21])
        return np.stack([r[..., :21] @ q[:21], rate[..., :21] @ q[:21]])

    q = np.concatenate([sizes, f])
    J = np.stack(sliding_lines.design(t, f, sizes))
    for i in range(23):
        step = h * (np.arange(23) == i)
        assert_allclose(J[..., i], (parts(q + step) - parts(q - step)) / (2 * h), atol=1e-5)  # h^2 times 2 pi f t cubed
    later = sliding_lines.design(t + h, f, sizes)[0][..., :21] @ sizes
    earlier = sliding_lines.design(t - h, f, sizes)[0][..., :21] @ sizes
    assert_allclose(parts(q)[1], (later - earlier) / (2 * h), atol=1e-6)  # r' is the derivative of r


def test_the_evidence_is_the_largest_likelihood_of_the_integrated_model():
    rng = np.random.default_rng(0)
    A, y = rng.normal(size=(30, 4)), 1.7 * rng.normal(size=30)
    ours, _, power = sliding_lines.evidence(A.T @ A, A.T @ y, float(y @ y), 30)

    def minus(logarithm):
        return -multivariate_normal(np.zeros(30), A @ A.T + np.exp(logarithm) * np.eye(30)).logpdf(y)

    found = minimize_scalar(minus, bounds=(-3, 4), method="bounded")
    assert power == pytest.approx(np.exp(found.x), rel=0.02)  # four rounds of a fixed point
    assert ours == pytest.approx(-found.fun + 15 * np.log(2 * np.pi), abs=0.05)  # the constant is left out
