"""Quaternion algebra against SciPy and its own laws."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from imubench import rotations

seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_agrees_with_scipy(seed):
    rng = np.random.default_rng(seed)
    p, q = rotations.random(rng, 2)
    v = rng.normal(size=3)
    P, Q = (Rotation.from_quat(x, scalar_first=True) for x in (p, q))
    assert_allclose(rotations.to_matrix(p), P.as_matrix(), atol=1e-12)
    assert_allclose(rotations.rotate(p, v), P.apply(v), atol=1e-12)
    assert_allclose(rotations.to_matrix(rotations.multiply(p, q)), (P * Q).as_matrix(), atol=1e-12)
    assert_allclose(rotations.log(p), P.as_rotvec(), atol=1e-9)
    assert_allclose(np.abs(rotations.from_matrix(P.as_matrix()) @ p), 1.0, atol=1e-12)


@given(seeds, st.floats(-8, 0))
def test_exp_and_log_are_inverse(seed, power):
    v = np.random.default_rng(seed).normal(size=3)
    v *= 3.0 * 10**power / np.linalg.norm(v)
    assert_allclose(rotations.log(rotations.exp(v)), v, rtol=1e-7, atol=1e-12)


@given(seeds)
def test_turning_back_undoes_turning(seed):
    rng = np.random.default_rng(seed)
    q, v = rotations.random(rng, 4), rng.normal(size=(4, 3))
    assert_allclose(rotations.rotate_back(q, rotations.rotate(q, v)), v, atol=1e-12)
    assert_allclose(rotations.rotate(rotations.conjugate(q), v), rotations.rotate_back(q, v), atol=1e-12)


def test_angle_between_is_accurate_near_zero_and_pi():
    x = np.array([1.0, 0.0, 0.0])
    small = np.array([np.cos(1e-9), np.sin(1e-9), 0.0])
    assert_allclose(rotations.angle_between(x, small), 1e-9, rtol=1e-6)
    assert_allclose(rotations.angle_between(x, -small), np.pi - 1e-9, rtol=1e-15)


def test_log_and_exp_at_the_identity():
    assert_allclose(rotations.exp(np.zeros(3)), [1, 0, 0, 0])
    assert_allclose(rotations.log(np.array([-1.0, 0, 0, 0])), 0.0)
