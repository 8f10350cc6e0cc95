"""One hypothesis more in the model, fitted exactly: motion, geometry and effects together."""

from collections.abc import Collection
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import Tracks
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.motion_prior import TILT
from imubench.diagnosis.problem.residuals import Parameters, Rows, is_data
from imubench.diagnosis.solve.gauss_newton import all_rows, extended, factored
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.marginals import covariance_of
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.diagnosis.solve.threads import one_thread

_known: WeakKeyDictionary[Fit, float] = WeakKeyDictionary()


def refit(
    fit: Fit, hypotheses: tuple[Hypothesis, ...], guess: dict[str, Array] | None = None, steps: int = SOLVER.refit_steps
) -> Fit:
    """Return the solved fit with these effects, at the noise levels that `fit` has."""
    begun = extended(fit, hypotheses, guess)
    return solve(begun.model, begun.state, begun.noise, fit.anchor, steps=steps)


def refit_without(fit: Fit, gone: Collection[Hypothesis], steps: int = SOLVER.refit_steps) -> Fit:
    """Return the solved fit without some effects, at the noise levels that `fit` has."""
    return refit(fit, tuple(h for h in fit.model.hypotheses if h not in gone), steps=steps)


@one_thread
def log_evidence(fit: Fit) -> float:
    """Return the Laplace approximation of the log evidence, up to what all models of a recording share.

    Its determinant is that of clocks as they are stamped, to a part of a knot's interval: samples in the middle of the
    intervals do not see waves of half the knots' rate, those a little beside do, and the motion's prior allows much of
    them. With the moved stamps such waves would count as information about a clock's offset.

    It is kept as long as its fit is: one fit is held against ten others.
    """
    if fit not in _known:
        _known[fit] = _log_evidence(fit)
    return _known[fit]


def _log_evidence(fit: Fit) -> float:
    rows = [r for r in fit.rows if not r.name.startswith(TILT)]
    _, solution, _ = factored(fit.model, as_stamped(fit) or rows)
    own = [h.key(s.name) for h in fit.model.hypotheses for s in h.effect.states]
    prior = sum(float(np.log(p.std).sum()) for p in fit.model.priors.values())
    density = sum(noise_density(r) for r in rows if is_data(r))
    spread = 0.5 * (states_log_det(fit.model, rows, own) - solution.log_det)
    return density - sum(r.cost for r in rows) - prior + spread


def as_stamped(fit: Fit) -> list[Rows]:
    """Return the rows of a fit with its clocks as near as samples lie between knots as stamped; none: they do."""
    model = fit.model
    values: dict[str, Array] = {}
    for h in model.hypotheses:
        own = {p.name: fit.state.values[h.key(p.name)] for p in h.effect.parameters}
        values |= {h.key(name): value for name, value in h.effect.aligned(own, model.tracks.knots.step).items()}
    if not values:
        return []
    state = replace(fit.state, values=fit.state.values | values)
    rows = all_rows(model, state, fit.noise, fit.anchor, fit.loose)
    return [r for r in rows if not r.name.startswith(TILT)]


def evidence_over(before: Fit, after: Fit) -> float:
    """Return the nat by which one fit's evidence exceeds another's."""
    return log_evidence(after) - log_evidence(before)


def states_log_det(model: Model, rows: list[Rows], names: list[str]) -> float:
    """Return the log determinant of the states' own prior, the motion given, by the rows that are no measurements."""
    if not names:
        return 0.0
    tracks = Tracks(model.tracks.knots, {n: model.tracks.widths[n] for n in names})
    theirs = [r for r in rows if not r.counts and any(n in names for n, _ in r.residual.blocks)]
    normal = Normal.of(tracks, Parameters({}), [linearise(r, tracks, Parameters({})) for r in theirs])
    return normal.band.factor().log_det


def noise_density(rows: Rows) -> float:
    """Return what the noise level takes from the log likelihood: rows of a smaller one are worth more."""
    return -float(np.sum(rows.log_std))


@one_thread
def information(fit: Fit) -> tuple[Array, dict[str, Array]]:
    """Return the covariance (p, p) of all parameters, and every parameter's standard deviations."""
    _, solution, _ = factored(fit.model, [r for r in fit.rows if not r.name.startswith(TILT)])
    covariance = covariance_of(fit.model, solution.schur)
    std = np.sqrt(np.diag(covariance))
    return covariance, {name: std[fit.model.parameters.columns(name)] for name in fit.model.priors}


__all__ = ["evidence_over", "information", "log_evidence", "refit", "states_log_det"]
