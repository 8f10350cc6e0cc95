"""The block arithmetic of the fit against dense matrices."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.bspline import SUPPORT, Knots, Tracks
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.solve.block_tridiagonal import Banded, NotPositiveDefiniteError
from imubench.diagnosis.solve.bordered import solve_arrow
from imubench.diagnosis.solve.linearize import Held, linearise
from imubench.diagnosis.solve.marginals import inverse_windows
from imubench.diagnosis.solve.narrow_band import solved
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.diagnosis.solve.threads import side_by_side
from imubench.jets import CONSTANT, Jet

TRACKS = Tracks(Knots.over(0.0, 1.0, 0.04), {"a": 2, "b": 1})
PARAMETERS = Parameters({"p": 2, "q": 1})


def random_rows(rng, n=90, m=3):
    time = rng.uniform(0.0, 1.0, n)
    blocks = {("a", 0): rng.normal(size=(n, m, 2)), ("b", 1): rng.normal(size=(n, m, 1)) * 0.05}
    blocks |= {("p", CONSTANT): rng.normal(size=(n, m, 2)), ("q", CONSTANT): rng.normal(size=(1, m, 1))}
    return Rows("rows", time, Jet(rng.normal(size=(n, m)), blocks), np.array([1.0, 2.0, 0.5]))


def dense(rows):
    """The same Jacobian, built coefficient by coefficient."""
    n, m = rows.residual.value.shape
    count, width = TRACKS.knots.count, TRACKS.width
    out = np.zeros((n, m, count * width + PARAMETERS.count))
    for (name, order), block in rows.residual.blocks.items():
        block = np.broadcast_to(block, (n, *block.shape[1:]))
        if order == CONSTANT:
            out[:, :, count * width + np.arange(3)[PARAMETERS.columns(name)]] += block
            continue
        for knot in range(count):
            first, weights = TRACKS.knots.weights(rows.time, order)
            hit = (knot >= first) & (knot < first + 6)
            value = np.where(hit, weights[np.arange(n), np.clip(knot - first, 0, 5)], 0.0)
            columns = knot * width + np.arange(width)[TRACKS.columns(name)]
            out[:, :, columns] += block * value[:, None, None]
    return (out / rows.std[:, None]).reshape(n * m, -1)


@pytest.fixture
def system():
    rng = np.random.default_rng(3)
    normal = Normal.empty(TRACKS, PARAMETERS)
    parts = [random_rows(rng), random_rows(rng)]
    normal.add([linearise(rows, TRACKS, PARAMETERS) for rows in parts])
    jacobian = np.concatenate([dense(rows) for rows in parts])
    ridge = np.eye(normal.diagonal.shape[1])
    normal.diagonal += ridge
    size = TRACKS.knots.count * TRACKS.width
    matrix = jacobian.T @ jacobian
    matrix[:size, :size] += np.eye(size)
    residual = np.concatenate([rows.whitened.reshape(-1) for rows in parts])
    return normal, matrix, jacobian.T @ residual, size


def test_the_solution_is_the_dense_one(system):
    normal, matrix, gradient, size = system
    solution = solve_arrow(normal.band, normal.border, normal.corner)
    x, p = solution.solve(normal.gradient[:, :, None], normal.corner_gradient[:, None])
    exact = np.linalg.solve(matrix, gradient)
    assert_allclose(x.reshape(-1)[:size], exact[:size], rtol=1e-8, atol=1e-10)  # condition number 1e5
    assert_allclose(p[:, 0], exact[size:], rtol=1e-8)
    assert_allclose(np.linalg.inv(solution.schur), np.linalg.inv(matrix)[size:, size:], rtol=1e-8)


def test_the_inverse_has_the_dense_ones_blocks(system):
    normal, matrix, _, size = system
    exact = np.linalg.inv(matrix[:size, :size])
    blocks, b, c = len(normal.diagonal), normal.diagonal.shape[1], normal.right.shape[1]
    compared = 0
    for i, (own, right) in zip(reversed(range(blocks)), normal.band.factor().inverse(), strict=True):
        here, after = i * b, (i + 1) * b
        if after <= size:  # the last block has coefficients that no row touches
            assert_allclose(own, exact[here:after, here:after], rtol=1e-7, atol=1e-9)
            compared += 1
        if after + c <= size:
            assert_allclose(right, exact[after - c : after, after : after + c], rtol=1e-7, atol=1e-9)
    assert compared >= 2


def test_further_columns_are_projected(system):
    normal, matrix, _, size = system
    rng = np.random.default_rng(5)
    g = rng.normal(size=(*normal.gradient.shape, 2))
    g.reshape(-1, 2)[size:] = 0.0
    h, c = rng.normal(size=(3, 2)), np.eye(2) * 1e3
    solution = solve_arrow(normal.band, normal.border, normal.corner)
    column = np.concatenate([g.reshape(-1, 2)[:size], h])
    exact = c - column.T @ np.linalg.solve(matrix, column)
    assert_allclose(solution.complement(g, h, c), exact, rtol=1e-8)


def test_further_columns_of_several_draws_are_projected_one_by_one(system):
    normal, matrix, _, size = system
    rng = np.random.default_rng(6)
    g = rng.normal(size=(*normal.gradient.shape, 2, 4))
    g.reshape(-1, 2, 4)[size:] = 0.0
    h, c = rng.normal(size=(3, 2, 4)), np.eye(2) * 1e3
    columns = np.concatenate([g.reshape(-1, 2, 4)[:size], h]).transpose(2, 0, 1)
    exact = c - sum(column.T @ np.linalg.solve(matrix, column) for column in columns)
    solution = solve_arrow(normal.band, normal.border, normal.corner)
    assert_allclose(solution.complements(g, h, c), exact, rtol=1e-8)


def test_a_direction_that_nothing_holds_is_named():
    normal = Normal.empty(TRACKS, PARAMETERS)
    with pytest.raises(NotPositiveDefiniteError, match="block 0"):
        normal.band.factor()


@pytest.mark.parametrize(("blocks", "width"), [(70, 3), (2, 2), (1, 1)])
def test_the_windows_of_an_inverse_are_the_dense_one_s_blocks(blocks, width):
    rng, b, c = np.random.default_rng(0), ALGEBRA.knots_per_block * width, (SUPPORT - 1) * width
    diagonal, right = rng.normal(size=(blocks, b, b)), rng.normal(size=(blocks, c, c))
    diagonal = diagonal + np.swapaxes(diagonal, 1, 2) + 20 * b * np.eye(b)
    whole = np.zeros((blocks * b, blocks * b))
    for i in range(blocks):
        own = slice(i * b, (i + 1) * b)
        whole[own, own] = diagonal[i]
        if i + 1 < blocks:
            last, first = slice((i + 1) * b - c, (i + 1) * b), slice((i + 1) * b, (i + 1) * b + c)
            whole[last, first], whole[first, last] = right[i], right[i].T
    inverse = np.linalg.inv(whole)
    found = np.concatenate(list(inverse_windows(Banded(diagonal, right).factor(), width))[::-1])
    for k in range(blocks * ALGEBRA.knots_per_block - SUPPORT + 1):  # knots that a row can begin at
        span = slice(k * width, (k + SUPPORT) * width)
        assert_allclose(found[k], inverse[span, span], rtol=1e-9, atol=1e-15)


def test_few_splines_alone_are_solved_as_a_band(system):
    normal, matrix, gradient, size = system
    x = solved(normal, np.stack([normal.gradient, 2 * normal.gradient], axis=2))
    exact = np.linalg.solve(matrix[:size, :size], gradient[:size])
    assert_allclose(x[:, :, 0].reshape(-1)[:size], exact, rtol=1e-8, atol=1e-10)
    assert_allclose(x[:, :, 1], 2 * x[:, :, 0], rtol=1e-12)


def test_what_nothing_holds_is_named_in_a_band_too():
    normal = Normal.empty(TRACKS, PARAMETERS)
    with pytest.raises(NotPositiveDefiniteError):
        solved(normal, normal.gradient[:, :, None])


def test_pieces_made_side_by_side_keep_their_order_and_do_their_own_pieces_themselves():
    inner = list(side_by_side(lambda i: list(side_by_side(lambda j: 10 * i + j, range(3))), range(20)))
    assert inner == [[10 * i, 10 * i + 1, 10 * i + 2] for i in range(20)]


def test_what_a_piece_raises_is_raised():
    def piece(i):
        if i == 7:
            raise ValueError("seven")
        return i

    with pytest.raises(ValueError, match="seven"):
        list(side_by_side(piece, range(20)))


@pytest.mark.parametrize("count", [1, 4])
def test_a_jacobian_that_is_held_multiplies_as_one_made_anew(count):
    rng = np.random.default_rng(8)
    part = linearise(random_rows(rng), TRACKS, PARAMETERS)
    columns = rng.normal(size=(*part.residual.shape, count))
    anew, held = np.zeros((2, TRACKS.knots.count, TRACKS.width, count))
    part.scatter(columns, anew)
    Held.of(part).scatter(columns, held)
    assert_allclose(held, anew, rtol=1e-12, atol=1e-12)  # rounding: one column may be summed in another order
