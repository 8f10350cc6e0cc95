"""Rows that share their place between knots, together with such that do not: their products are the dense ones."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.alike_rows import alike
from imubench.diagnosis.problem.bspline import Knots, Tracks
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.solve import linearize
from imubench.diagnosis.solve.bordered import solve_arrow
from imubench.diagnosis.solve.linearize import Held, Stack, linearise
from imubench.diagnosis.solve.marginals import Marginals
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.jets import CONSTANT, Jet

TRACKS = Tracks(Knots.over(0.0, 6.0, 0.04), {"a": 2, "b": 1, "c": 3})  # more than one piece of knots
PARAMETERS = Parameters({"p": 2})
MIDDLES = TRACKS.knots.start + 0.04 * (np.arange(TRACKS.knots.count - 5) + 0.5)


def rows(rng, name, time, keys, m=3, border=True):
    widths, n = TRACKS.widths, len(time)
    blocks = {(key, order): rng.normal(size=(n if order else 1, m, widths[key])) * 0.04**order for key, order in keys}
    if border:
        blocks["p", CONSTANT] = rng.normal(size=(n, m, 2))
    return Rows(name, time, Jet(rng.normal(size=(n, m)), blocks), rng.uniform(0.5, 2.0, (n, m)))


@pytest.fixture
def parts():
    rng = np.random.default_rng(1)
    law = rows(rng, "law", MIDDLES[10:-12], [("a", 0), ("a", 2), ("c", 1)])
    prior = rows(rng, "prior", MIDDLES, [("c", 2)], m=2, border=False)
    hold = rows(rng, "hold", MIDDLES, [("a", 4), ("b", 0)], border=False)
    even = rows(rng, "even", np.delete(0.013 + 0.04 * np.arange(150), [3, 70, 71]), [("b", 0), ("b", 1), ("c", 0)])
    drifting = rows(rng, "drifting", 0.0391 * np.arange(150), [("a", 1), ("b", 0)])  # at some knots two samples
    shuffled = rows(rng, "shuffled", rng.permutation(0.02 + 0.04 * np.arange(140)), [("c", 0)])
    none = Rows("none", np.zeros(1), Jet(rng.normal(size=(1, 2)), {("p", CONSTANT): np.eye(2)[None]}), np.ones(2))
    return [linearise(r, TRACKS, PARAMETERS) for r in (drifting, law, even, prior, none, shuffled, hold)]


def dense(part):
    """The Jacobian of all rows by all coefficients and numbers, sample by sample."""
    n, m = part.residual.shape
    out = np.zeros((n, m, TRACKS.knots.count, TRACKS.width))
    for at, order, block in part.blocks:
        for i, d in enumerate(np.broadcast_to(block, (n, *block.shape[1:]))):
            for s, w in enumerate(part.weights[order][i]):
                out[i, :, part.first[i] + s, at] += w * (part.scale[i, :, None] * d)
    return np.concatenate([out.reshape(n, m, -1), part.border], axis=2).reshape(n * m, -1)


def test_what_shares_a_place_is_found(parts):
    groups = {group.members for group in alike(parts)}
    assert groups == {(1, 3, 6), (2,)}
    again = [replace(part, phase=None) for part in parts]
    assert alike(again) == []


@pytest.fixture(params=[8, 64, 10_000])
def chunk(request, monkeypatch):
    """Rows of so many knots put together at once, of 156."""
    numbers = request.param * (6 * TRACKS.width) ** 2
    monkeypatch.setattr(linearize, "ALGEBRA", replace(ALGEBRA, chunk_numbers=numbers))
    assert linearize.chunk_knots(TRACKS.width) == request.param


def test_normal_equations_are_the_dense_ones(parts, chunk):
    jacobian = np.concatenate([dense(part) for part in parts])
    residual = np.concatenate([part.residual.reshape(-1) for part in parts])
    exact, gradient = jacobian.T @ jacobian, jacobian.T @ residual
    normal = Normal.empty(TRACKS, PARAMETERS)
    normal.add(parts)
    size, b, c = TRACKS.knots.count * TRACKS.width, normal.diagonal.shape[1], normal.right.shape[1]
    for i, own in enumerate(normal.diagonal):
        here, end = i * b, min((i + 1) * b, size)
        assert_allclose(own[: end - here, : end - here], exact[here:end, here:end], rtol=1e-9, atol=1e-9)
        if end + c <= size:
            assert_allclose(normal.right[i], exact[end - c : end, end : end + c], rtol=1e-9, atol=1e-9)
    assert_allclose(normal.border.reshape(-1, 2)[:size], exact[:size, size:], rtol=1e-9, atol=1e-9)
    assert_allclose(normal.gradient.reshape(-1)[:size], gradient[:size], rtol=1e-9, atol=1e-9)
    assert_allclose(normal.corner, exact[size:, size:], rtol=1e-9)
    assert_allclose(normal.corner_gradient, gradient[size:], rtol=1e-9)


def test_leverages_are_those_of_rows_made_one_by_one(parts, chunk):
    def leverages(some):
        normal = Normal.empty(TRACKS, PARAMETERS)
        normal.add(some)
        normal.diagonal += np.eye(normal.diagonal.shape[1])
        solution = solve_arrow(normal.band, normal.border, normal.corner)
        return Marginals.of(solution, TRACKS.width).leverages(some)

    for one, other in zip(leverages(parts), leverages([replace(p, phase=None) for p in parts]), strict=True):
        assert np.any(one > 0)
        assert_allclose(one, other, rtol=1e-9, atol=1e-12)


def test_pieces_of_one_kind_are_its_jacobian(parts, chunk):
    rng = np.random.default_rng(2)
    knots = rng.normal(size=(TRACKS.knots.count, TRACKS.width, 2))
    for part in parts:
        flat, columns = dense(part)[:, : knots[:, :, 0].size], rng.normal(size=(*part.residual.shape, 2))
        assert_allclose(part.along(knots).reshape(len(flat), 2), flat @ knots.reshape(-1, 2), rtol=1e-9, atol=1e-9)
        for scatter in (part.scatter, Held.of(part).scatter):
            target = np.zeros_like(knots)
            scatter(columns, target)
            exact = (flat.T @ columns.reshape(-1, 2)).reshape(target.shape)
            assert_allclose(target, exact, rtol=1e-9, atol=1e-9)


def test_what_no_spline_is_in_has_no_row_by_a_spline(parts):
    stack = Stack(parts)
    for begin in stack.begins:
        tall, places = stack.piece(begin)
        some, place = places[4]
        assert not tall[place][..., : 6 * TRACKS.width].any()
        assert_allclose(tall[place][..., -1], parts[4].residual[some])
