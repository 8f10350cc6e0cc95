"""How uncertain what a user asks for is in a fit, and by how much worse it is for a finding that is left out.

The fit's posterior is Gaussian about its state, with the inverse of the normal equations as covariance: with N = L L'
of the splines, B their border and S the Schur complement of the shared numbers p,

    p ~ N(0, S^-1),    x = -N^-1 B p + L'^-1 z,    z white

With W W' = S^-1 and the squares of what `moves_between` says of a state beside the fit's, s^2 is the sum over the
columns of W (p = w) and the mean over some draws of z (p = 0). The noise is taken for white, so s is rather too small.

Let s be the standard deviation of an answer with a finding in the fit, s_o without it, and d the shift between both.
The finding's numbers are estimates themselves, so d holds their chance, too: E d^2 = D^2 + (s^2 - s_o^2), with D what
the finding does and, of two efficient estimates, the variance of their difference (Hausman 1978, Econometrica 46,
1251). The mean square error of the answer is s^2 with the finding, s_o^2 + D^2 without it, and so the answer is

    sqrt(d^2 + 2 s_o^2 - s^2) - s

farther off without it, or not at all where that is negative: by d where the answer is exact, by nothing where the
finding's numbers are too uncertain to make it any better. A model with fewer numbers knows its answers no worse; where
it seems to, by another linearisation, s_o counts as s.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.verdict import SHIFT
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.motion_prior import TILT
from imubench.diagnosis.result import Move
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.bordered import Solution
from imubench.diagnosis.solve.gauss_newton import factored
from imubench.diagnosis.solve.marginals import covariance_of
from imubench.diagnosis.solve.retract import moved
from imubench.diagnosis.solve.threads import one_thread
from imubench.diagnosis.verdict.estimate_shift import estimates_of, moves_between, times

Spread = Mapping[str, Array]
"""Standard deviations of what a user asks for, by its name, in the unit and shape of the moves of that name."""

_known: WeakKeyDictionary[Fit, Spread] = WeakKeyDictionary()


def spread_of(fit: Fit) -> Spread:
    """Return the standard deviations of what a user asks for; empty where not all of the motion is held.

    They are kept as long as the fit is: what findings move alone, and together, and what doubts matter asks for them.
    """
    if fit not in _known:
        _known[fit] = _spread(fit)
    return _known[fit]


@one_thread
def _spread(fit: Fit) -> Spread:
    time = times(fit)
    here = estimates_of(fit, time)
    squares: dict[str, Array] = {}
    try:
        _, solution, _ = factored(fit.model, [r for r in fit.rows if not r.name.startswith(TILT)])
    except NotPositiveDefiniteError:
        return {}
    for share, state in (*by_numbers(fit, solution), *by_splines(fit, solution)):
        there = estimates_of(replace(fit, state=state), time)
        for name, move in moves_between(here, there, fit.model.recording).items():
            squares[name] = squares.get(name, 0.0) + share * move.value**2
    return {name: np.sqrt(square) for name, square in squares.items()}


def by_numbers(fit: Fit, solution: Solution) -> Iterator[tuple[float, State]]:
    """Yield states one standard deviation of the shared numbers away, along every axis of their covariance."""
    wide = root(covariance_of(fit.model, solution.schur))
    splines = solution.factor.backward(-(solution.half @ wide))
    yield from ((1.0, moved(fit.model, fit.state, splines[:, :, i], wide[:, i])) for i in range(wide.shape[1]))


def by_splines(fit: Fit, solution: Solution) -> Iterator[tuple[float, State]]:
    """Yield states with drawn splines, the shared numbers as they are, and the share of each."""
    blocks, b, p = solution.border.shape
    draws = np.random.default_rng(SHIFT.seed).standard_normal((SHIFT.draws, blocks, b))
    splines = solution.factor.backward(np.moveaxis(draws, 0, 2))
    yield from (
        (1 / SHIFT.draws, moved(fit.model, fit.state, splines[:, :, i], np.zeros(p))) for i in range(SHIFT.draws)
    )


def root(covariance: Array) -> Array:
    """Return W (k, k) with W W' a covariance."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def farther_off(moves: Mapping[str, Move], spread: Spread, without: Spread | None = None) -> dict[str, Move]:
    """Return by how much farther off what a user asks for is for shifts.

    Args:
        moves: the shifts.
        spread: standard deviations of the answers that are shifted from.
        without: those of the answers that are shifted to; None: the same, for none of these numbers is estimated.
    """
    out = {}
    for name, move in moves.items():
        std = spread.get(name, np.zeros(()))
        other = np.minimum(std if without is None else without.get(name, std), std)
        out[name] = Move(np.sqrt(np.maximum(move.value**2 + 2 * other**2 - std**2, std**2)) - std, move.unit)
    return out


__all__ = ["Spread", "farther_off", "root", "spread_of"]
