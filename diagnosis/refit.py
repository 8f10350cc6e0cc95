"""One hypothesis more in the model, fitted exactly: motion, geometry and effects together."""

from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.blocks import solve_arrow
from imubench.diagnosis.equations import equation_rows
from imubench.diagnosis.fit import Fit, all_rows, assemble, solve
from imubench.diagnosis.model import Hypothesis, Model, State
from imubench.diagnosis.score import started
from imubench.diagnosis.threads import one_thread

STATE_SMOOTH = 1e3  # roughness of an effect's states, before it is estimated
LOOSE_LAW = 100.0  # of the std of a law that states obey: tightened as fast as the recording says so


def extended(fit: Fit, hypotheses: tuple[Hypothesis, ...], guess: dict[str, Array] | None = None) -> Fit:
    """Return the fit's state in a model with these effects, parameters at `guess` or their start, not yet solved."""
    model = fit.model.with_effects(hypotheses)
    state = started(model, _kept(fit, model))
    state = State(state.coefficients, state.values | (guess or {}))
    noise = dict(fit.noise)
    for h in hypotheses:
        for s in h.effect.states:
            noise.setdefault(f"smooth.{h.key(s.name)}", STATE_SMOOTH)
    for rows in equation_rows(model, state):
        noise.setdefault(rows.name, LOOSE_LAW)
    return replace(fit, model=model, state=state, noise=noise)


def _kept(fit: Fit, model: Model) -> State:
    """Return the state with the splines and parameters that `model` still has, in its order."""
    old = fit.model.tracks
    kept = [fit.state.coefficients[:, old.columns(n)] for n in model.tracks.widths if n in old.widths]
    values = {n: v for n, v in fit.state.values.items() if n in model.priors}
    return State(np.concatenate(kept, axis=1), values)


def refit(fit: Fit, hypotheses: tuple[Hypothesis, ...], guess: dict[str, Array] | None = None, steps: int = 6) -> Fit:
    """Return the solved fit with these effects, at the noise levels that `fit` has."""
    begun = extended(fit, hypotheses, guess)
    return solve(begun.model, begun.state, begun.noise, fit.anchor, steps=steps)


def guess_of(h: Hypothesis, estimate: Array) -> dict[str, Array]:
    """Return a score's estimate (k,) by parameter name."""
    out, at = {}, 0
    for p in h.effect.parameters:
        out[h.key(p.name)] = estimate[at : at + p.width]
        at += p.width
    return out


@one_thread
def log_evidence(fit: Fit) -> float:
    """Return the Laplace approximation of the log evidence, up to what all models of a recording share."""
    normal, _ = assemble(fit.model, fit.rows)
    solution = solve_arrow(normal.band, normal.border, normal.corner)
    own = [n for h in fit.model.hypotheses for s in h.effect.states for n in [h.key(s.name)]]
    loss = 2 * float(np.log(np.diagonal(solution.factor.lower, axis1=1, axis2=2)).sum())
    loss += float(np.linalg.slogdet(solution.schur)[1])
    prior = sum(float(np.log(p.std).sum()) for p in fit.model.priors.values())
    return -fit.cost - 0.5 * loss - prior + 0.5 * _states_logdet(fit, own)


def _states_logdet(fit: Fit, names: list[str]) -> float:
    """Return the log determinant of the states' own prior, the motion given."""
    if not names:
        return 0.0
    from imubench.diagnosis.rows import Normal, Parameters, linearise
    from imubench.diagnosis.splines import Tracks

    tracks = Tracks(fit.model.tracks.knots, {n: fit.model.tracks.widths[n] for n in names})
    normal = Normal.empty(tracks, Parameters({}))
    rows = [r for r in fit.rows if not r.counts and any(n in names for n, _ in r.residual.blocks)]
    normal.add([linearise(r, tracks, Parameters({})) for r in rows])
    normal.fill(tracks)
    return 2 * float(np.log(np.diagonal(normal.band.factor().lower, axis1=1, axis2=2)).sum())


@one_thread
def information(fit: Fit) -> tuple[Array, dict[str, Array]]:
    """Return the covariance (p, p) of all parameters, and every parameter's standard deviations."""
    normal, _ = assemble(fit.model, fit.rows)
    covariance = np.asarray(np.linalg.inv(solve_arrow(normal.band, normal.border, normal.corner).schur), dtype=float)
    std = np.sqrt(np.diag(covariance))
    return covariance, {name: std[fit.model.parameters.columns(name)] for name in fit.model.priors}


__all__ = ["all_rows", "extended", "guess_of", "information", "log_evidence", "refit"]
