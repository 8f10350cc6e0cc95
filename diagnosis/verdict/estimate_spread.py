"""How uncertain what a user asks for is in a fit, and by how much farther off a shift makes it.

The fit's posterior is Gaussian about its state, with the inverse of the normal equations N as covariance. With N = L L'
and the shared numbers' Schur complement S = K K', draws are

    p = K'^-1 z_p,    x = L'^-1 (z_x - L^-1 B p),    z white

and s is the RMS over draws of what `moves_between` says of a draw beside the fit. The noise is taken for white, so s is
rather too small than too large.

An answer that is off by chance alone has an RMS error of s, one that is shifted by d besides sqrt(s^2 + d^2). So d
makes it farther off by sqrt(s^2 + d^2) - s: by d where the answer is exact, by next to nothing where chance moves it
farther than d does.
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
from imubench.diagnosis.solve.gauss_newton import factored
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
        for state in draws(fit):
            there = estimates_of(replace(fit, state=state), time)
            for name, move in moves_between(here, there, fit.model.recording).items():
                squares[name] = squares.get(name, 0.0) + move.value**2 / SHIFT.draws
    except NotPositiveDefiniteError:
        return {}
    return {name: np.sqrt(square) for name, square in squares.items()}


def draws(fit: Fit) -> Iterator[State]:
    """Yield states drawn from a fit's posterior.

    Raises:
        NotPositiveDefiniteError: where nothing holds a direction.
    """
    _, solution, _ = factored(fit.model, [r for r in fit.rows if not r.name.startswith(TILT)])
    rng = np.random.default_rng(SHIFT.seed)
    blocks, b, p = solution.border.shape
    try:
        upper = np.linalg.cholesky(solution.schur).T
    except np.linalg.LinAlgError:
        raise NotPositiveDefiniteError("the shared parameters") from None
    values = np.linalg.solve(upper, rng.standard_normal((p, SHIFT.draws)))
    splines = solution.factor.backward(rng.standard_normal((blocks, b, SHIFT.draws)) - solution.half @ values)
    yield from (moved(fit.model, fit.state, splines[:, :, i], values[:, i]) for i in range(SHIFT.draws))


def farther_off(moves: Mapping[str, Move], spread: Spread) -> dict[str, Move]:
    """Return by how much farther off shifts make what a user asks for, each beside its own standard deviation."""
    out = {}
    for name, move in moves.items():
        std = spread.get(name, np.zeros(()))
        out[name] = Move(np.hypot(move.value, std) - std, move.unit)
    return out


__all__ = ["Spread", "draws", "farther_off", "spread_of"]
