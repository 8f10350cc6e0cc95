"""Rows whose derivatives are taken through a segment's motion are those of derivatives carried from the splines on."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.chain_rule import carrier, chained
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem import batch_model, process_factors
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.solve.gauss_newton import all_rows
from imubench.diagnosis.solve.refit import extended
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.jets import Jet, cross, derivatives_by
from imubench.links import Motion
from imubench.proof.case import make_case

MODELS = {
    "hinge": (("rocking_mount", "imu2"), ("joint_play", "joint"), ("time_offset", "imu2"), ("g_sensitivity", "imu1")),
    "pendulum": (("soft_mount", "imu1"), ("skin_sliding", "imu1")),
    "free": (("low_pass", "imu1"), ("mount_pose", "imu1")),
}


@pytest.fixture(scope="module", params=MODELS)
def begun(request, tmp_path_factory):
    """A fit of some seconds with effects of several kinds in it, every spline and number of theirs somewhere."""
    folder = tmp_path_factory.mktemp("rows") / "r"
    make_case(folder, request.param, [], 4, seconds=4.0, rate=50.0)
    effects = tuple(Hypothesis(EFFECTS[name], at) for name, at in MODELS[request.param])
    fit = extended(nominal_fit(read(folder)[0]), effects)
    rng = np.random.default_rng(2)
    off = {n: v + 0.01 * rng.normal(size=v.shape) for n, v in fit.state.values.items()}
    coefficients = fit.state.coefficients + 0.01 * rng.normal(size=fit.state.coefficients.shape)
    return fit, State(coefficients, off)


def same(rows, others):
    compared = 0
    for one, other in zip(rows, others, strict=True):
        assert one.name == other.name
        assert_allclose(one.residual.value, other.residual.value, rtol=1e-12, atol=1e-12)
        assert one.residual.blocks.keys() == other.residual.blocks.keys()
        for key, block in one.residual.blocks.items():
            there = np.broadcast_to(
                other.residual.blocks[key], np.broadcast_shapes(block.shape, other.residual.blocks[key].shape)
            )
            assert_allclose(
                np.broadcast_to(block, there.shape), there, rtol=1e-9, atol=1e-9 * max(np.abs(there).max(), 1.0)
            )
            compared += 1
    assert compared


@pytest.mark.parametrize("alone", [None, ("own",)])
def test_rows_are_those_of_the_plain_rule(begun, monkeypatch, alone):
    fit, state = begun
    names = None if alone is None else [h.key(s.name) for h in fit.model.hypotheses for s in h.effect.states]

    def rows():
        if names is None:
            return all_rows(fit.model, state, fit.noise, fit.anchor)
        with derivatives_by(names):
            return all_rows(fit.model, state, fit.noise, fit.anchor)

    found = rows()
    monkeypatch.setattr(batch_model, "carrier", lambda motion: motion)
    monkeypatch.setattr(process_factors, "carrier", lambda motion: motion)
    same(found, rows())


def test_what_depends_on_few_numbers_stays_as_it_is():
    """A hinge on a fixed base turns by one number: three variables in its place would be more."""
    few = Jet(np.ones((5, 3)), {("hinge", 1): np.ones((1, 3, 1))})
    many = Jet(np.ones((5, 3)), {("a", 0): np.ones((5, 3, 4)), ("b", -1): np.ones((1, 3, 1))})
    moved = carrier(Motion(few, many, few))
    assert moved.rate.blocks.keys() == {("hinge", 1)}
    assert moved.accel.blocks.keys() != many.blocks.keys()
    back = chained(cross(moved.rate, moved.accel), moved)
    plain = cross(few, many)
    assert back.blocks.keys() == plain.blocks.keys()
    for key, block in plain.blocks.items():
        assert_allclose(back.blocks[key], np.broadcast_to(block, back.blocks[key].shape), atol=1e-14)
