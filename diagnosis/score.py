"""Every candidate effect scored from one fit: what it would explain, before anything is fitted anew.

With g the gradient of the cost by an effect's parameters and M their information once the motion,
the geometry and the effects already in the model are free to move, the quadratic model of the cost
promises a gain of g' (M + L)^-1 g / 2, L the prior's information; its Laplace evidence subtracts
log det(I + L^-1 M) / 2, the price of the freedom. (M + L)^-1 is also the Cramer-Rao bound.
"""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.blocks import solve_arrow
from imubench.diagnosis.fit import Fit, all_rows, assemble
from imubench.diagnosis.model import Hypothesis, Model, State
from imubench.diagnosis.threads import one_thread


@dataclass(frozen=True)
class Score:
    """What a hypothesis promises."""

    hypothesis: Hypothesis
    gain: float  # nat, of the log likelihood and prior
    evidence: float  # nat, the gain less the price of its freedom
    estimate: Array  # (k,) the parameters it would take, one linear step from the fit
    bound: Array  # (k,) their standard deviations
    information: Array  # (k, k)
    gradient: Array  # (k,)


def started(model: Model, state: State) -> State:
    """Return the state with every parameter and spline of `model`, the missing ones at their start."""
    values = {name: state.values.get(name, prior.start.copy()) for name, prior in model.priors.items()}
    missing = model.tracks.width - state.coefficients.shape[1]
    extra = np.zeros((len(state.coefficients), missing))
    return State(np.concatenate([state.coefficients, extra], axis=1), values)


@one_thread
def score(fit: Fit, candidates: list[Hypothesis]) -> list[Score]:
    """Return the scores of effects without states, best evidence first."""
    if not candidates:
        return []
    model = fit.model.with_effects((*fit.model.hypotheses, *candidates))
    state = started(model, fit.state)
    rows = all_rows(model, state, fit.noise, fit.anchor, fit.loose)
    priors = {f"prior.{h.key(p.name)}" for h in candidates for p in h.effect.parameters}
    normal, _ = assemble(model, [r for r in rows if r.name not in priors])
    parameters = model.parameters
    fresh = np.concatenate([np.r_[parameters.columns(h.key(p.name))] for h in candidates for p in h.effect.parameters])
    solution = solve_arrow(normal.band, normal.border, normal.corner)
    front = solution.factor.forward(normal.gradient[:, :, None])
    gradient = normal.corner_gradient - np.einsum("mbp,mb->p", solution.half, front[:, :, 0])
    old = np.setdiff1d(np.arange(parameters.count), fresh)
    known = np.linalg.solve(solution.schur[np.ix_(old, old)], solution.schur[np.ix_(old, fresh)])
    information = solution.schur[np.ix_(fresh, fresh)] - solution.schur[np.ix_(fresh, old)] @ known
    force = gradient[fresh] - known.T @ gradient[old]
    out = []
    at = 0
    for h in candidates:
        width = sum(p.width for p in h.effect.parameters)
        here = slice(at, at + width)
        prior = np.concatenate([model.priors[h.key(p.name)].std for p in h.effect.parameters])
        out.append(_one(h, information[here, here], force[here], prior))
        at += width
    return sorted(out, key=lambda s: -s.evidence)


def _one(h: Hypothesis, information: Array, gradient: Array, prior: Array) -> Score:
    matrix = information * np.outer(prior, prior) + np.eye(len(prior))  # in units of the prior
    step = -np.linalg.solve(matrix, gradient * prior)
    gain = -0.5 * float(step @ (gradient * prior))
    price = 0.5 * float(np.linalg.slogdet(matrix)[1])
    bound = prior * np.sqrt(np.diag(np.linalg.inv(matrix)))
    return Score(h, gain, gain - price, step * prior, bound, information, gradient)
