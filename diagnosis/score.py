"""Every candidate effect scored from one fit: what it would explain, before anything is fitted anew.

With g the gradient of the cost by an effect's parameters and M their information once the motion,
the geometry and the effects already in the model are free to move, the quadratic model of the cost
promises a gain of g' (M + L)^-1 g / 2, L the prior's information; its Laplace evidence subtracts
log det(I + L^-1 M) / 2, the price of the freedom. (M + L)^-1 is also the Cramer-Rao bound.
"""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.columns import promise
from imubench.diagnosis.fit import Fit, all_rows, factored
from imubench.diagnosis.hypothesis import Hypothesis, State
from imubench.diagnosis.model import Model
from imubench.diagnosis.threads import one_thread


@dataclass(frozen=True)
class Score:
    """What a hypothesis promises."""

    hypothesis: Hypothesis
    gain: float  # nat, of the log likelihood and prior
    evidence: float  # nat, the gain less the price of its freedom
    estimate: Array  # (k,) the parameters it would take, one linear step from the fit
    bound: Array  # (k,) their standard deviations


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
    normal, solution, _ = factored(model, [r for r in rows if r.name not in priors])
    fresh = model.parameters.places([h.key(p.name) for h in candidates for p in h.effect.parameters])
    information, force = solution.reduced(normal.gradient, normal.corner_gradient, fresh)
    out = []
    at = 0
    for h in candidates:
        width = sum(p.width for p in h.effect.parameters)
        here = slice(at, at + width)
        prior = np.concatenate([model.priors[h.key(p.name)].std for p in h.effect.parameters])
        found = promise(information[here, here], force[here], prior)
        out.append(Score(h, found.gain, found.evidence, found.step, found.bound))
        at += width
    return sorted(out, key=lambda s: -s.evidence)
