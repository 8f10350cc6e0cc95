"""Jets against finite differences, and rotations against SciPy's."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from imubench.jets import CONSTANT, Jet, Turn, about, cross, derivatives_by, dot, rotation, stack, variable

N = 5
A, B = ("a", 0), ("b", CONSTANT)


def laws(a, b):
    """Compositions of everything a law may use, from a jet a (N, 3) and a parameter b (1, 3)."""
    turn = rotation(b) @ rotation(0.3 * a)
    return {
        "sum": a + b - 2.0 * a + 1.0,
        "product": a * b * a,
        "quotient": a / (dot(b, b) + 1.0),
        "cross": cross(a, cross(b, a)),
        "back": turn.back(a),
        "forth": turn.forth(b),
        "inverse": (turn.inverse @ rotation(a)).back(cross(a, b)),
        "about": about(1, a[[0]]).back(b),
        "stack": stack(a[[2]], b[[0, 1]], np.ones((N, 1))),
        "matrix": a.at([[1.0, 2.0, 3.0], [0.0, 1.0, 0.0]]),
        "function": a.through(np.sin(a.value), np.cos(a.value)),
    }


def values(rng):
    return rng.normal(size=(N, 3)), rng.normal(size=(1, 3))


@pytest.mark.parametrize("name", list(laws(Jet(np.ones((N, 3))), Jet(np.ones((1, 3))))))
def test_blocks_are_the_derivatives(name):
    a, b = values(np.random.default_rng(4))
    law = laws(variable(A, a), variable(B, b))[name]
    step = 1e-6
    for key, which in ((A, 0), (B, 1)):
        for k in range(3):
            change = np.zeros(3)
            change[k] = step
            ends = [
                laws(*(Jet(x + s * change * (i == which)) for i, x in enumerate((a, b))))[name].value for s in (1, -1)
            ]
            finite = np.broadcast_to((ends[0] - ends[1]) / (2 * step), law.value.shape)
            block = law.blocks.get(key)
            exact = np.zeros_like(law.value) if block is None else np.broadcast_to(block[:, :, k], law.value.shape)
            assert_allclose(exact, finite, atol=1e-8)  # a central difference's own error


def test_a_turn_is_the_rotation_and_its_blocks_its_right_hand_change():
    v = np.random.default_rng(1).normal(size=(N, 3))
    v[0] = 1e-9  # the series near zero
    turn = rotation(variable(A, v))
    assert_allclose(turn.matrix, Rotation.from_rotvec(v).as_matrix(), atol=1e-14)
    for k in range(3):
        change = np.eye(3)[k] * 1e-6
        ends = [Rotation.from_rotvec(v + s * change) for s in (1, -1)]
        finite = (ends[1].inv() * ends[0]).as_rotvec() / 2e-6
        assert_allclose(np.broadcast_to(turn.blocks[A][:, :, k], (N, 3)), finite, atol=1e-8)  # difference's error


def test_without_blocks_a_law_is_plain_arithmetic():
    a, b = values(np.random.default_rng(2))
    for law in laws(Jet(a), Jet(b)).values():
        assert law.blocks == {}
    assert isinstance(rotation(a), Turn)


@pytest.mark.parametrize("name", list(laws(Jet(np.ones((N, 3))), Jet(np.ones((1, 3))))))
def test_derivatives_by_some_are_those_of_all(name):
    a, b = values(np.random.default_rng(5))
    whole = laws(variable(A, a), variable(B, b))[name]
    with derivatives_by(["b"]):
        part = laws(variable(A, a), variable(B, b))[name]
    assert_allclose(part.value, whole.value, atol=0)
    assert set(part.blocks) == set(whole.blocks) & {B}
    for key, block in part.blocks.items():
        assert_allclose(np.broadcast_to(block, whole.blocks[key].shape), whole.blocks[key], atol=1e-14)  # rounding


def test_derivatives_by_all_come_back_after_an_error():
    with pytest.raises(ValueError, match="inside"), derivatives_by([]):
        assert variable(A, np.ones((1, 3))).blocks == {}
        raise ValueError("inside")
    assert set(variable(A, np.ones((1, 3))).blocks) == {A}
