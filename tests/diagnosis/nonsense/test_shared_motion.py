"""How much two sensors' motions share."""

import numpy as np
import pytest

from imubench.diagnosis.nonsense.shared_motion import held_out, shared, squares
from imubench.diagnosis.nonsense.stretch import averaged, grid


def test_what_imus_share_does_not_depend_on_their_mounts_scales_and_biases(made):
    one, two = made("hinge", 1).imus
    edges = grid([one.time, two.time], 25.0)
    first, second = (averaged(i.time, i.gyro, edges) for i in (one, two))
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0] @ np.diag([1.1, 0.9, 1.0])
    plain, moved = (held_out(squares(first), squares(w)) for w in (second, second @ turn.T + [0.1, -0.2, 0.1]))
    # a linear map of the signals; what remains is the ridge of a thousandth
    assert moved == pytest.approx(plain, abs=0.01)
    assert plain > 0.95


def test_noise_shares_nothing_and_a_copy_everything():
    rng = np.random.default_rng(2)
    one, other = rng.standard_normal((2, 1000, 3))
    assert abs(held_out(one, other)) < 0.2  # 1 / sqrt(1000) is 0.03; the pair is chosen among three by three
    assert held_out(one, one @ rng.standard_normal((3, 3))) > 0.99
    assert shared(one, other, 0.04).unrelated
    assert not shared(one, one, 0.04).unrelated
    assert shared(one[:50], other[:50], 0.04) is None  # two seconds say nothing
