"""Whether the numbers of a model that was found may be believed, where no reference tells.

A fit in the wrong basin has a low residual, and numbers that one half of the recording takes from another cause than
the other half does. Each half's numbers are one Gauss-Newton step from those of the whole (`heldout`), with the
covariance of that half, as wide as the residuals' colour makes it. With d the difference of the halves' numbers and s
its standard deviation, a number is doubted where |d| > `rare_sigmas` s and |d| is more than it could be off and still
serve.

A number is doubted as well where it is far outside what nature has; both only if it matters: with the number held
where the halves differ from it, or where it would be plausible, and all others fitted anew, something that a user asks
for is farther off by the tolerance. How a spring that is hardly stretched is damped may be anything, and the axis is
the same. Nor does a number matter whose whole effect may be left out: answers that are the same with it and without it
lean on none of its numbers, and what is not likely is neither played nor taken out. The model as a whole is doubted
where the declared one predicts better what neither was fitted to. That it predicts worse than noise allows is no doubt:
it does not explain everything (`allowed`).
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.shared import DECLARED_NOISE, STATISTICS
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.config.verdict import TRUST
from imubench.diagnosis.criteria.cross_validation import block_of
from imubench.diagnosis.discrepancy.terms import Unknown
from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import is_data
from imubench.diagnosis.residual_checks.fit_summary import Weighed
from imubench.diagnosis.result import TOLERANCE, Doubt, Pair, is_material
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.bordered import solve_arrow
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.diagnosis.solve.refit import information
from imubench.diagnosis.solve.threads import one_thread
from imubench.diagnosis.verdict.estimate_shift import (
    Spread,
    estimates_of,
    farther_off,
    moves_between,
    spread_of,
    times,
)

PREDICTION = "prediction"  # of the model as a whole
SERVES_MOUNT = {"rotation": 0.05, "translation": 0.02}  # rad, m, of a mount: in the end the whole counts, not a half
DAMPING = "damping_ratio"  # may be as near to none as it likes: springs without are no oddity, only overdamped ones are


@dataclass(frozen=True)
class Question:
    """A number that may be wrong: why, and what it may as well be."""

    of: str
    why: str
    otherwise: Array  # the parameter (k,) as it may as well be


def doubts(
    fit: Fit, before: Weighed, after: Weighed, tolerance: Pair = TOLERANCE, unused: Collection[str] = ()
) -> tuple[Doubt, ...]:
    """Return what speaks against a model that was found.

    Args:
        fit: whose numbers are reported.
        before: the declared model's fit, its residuals beside the noise.
        after: that of the model that was found.
        tolerance: deg and mm by which what a user asks for may be off.
        unused: effects, as "effect@place", without which all of that is within the tolerance, or that are not likely.
    """
    worse = after.left_out > max(before.left_out, allowed(after))  # within what noise may have neither is better
    beaten = (Doubt(PREDICTION, "the declared model predicts better"),) if worse else ()
    every = [*implausible(fit), *halves_that_differ(fit)]
    asked_of = [q for q in every if q.of.rpartition(".")[0] not in unused]
    spread = spread_of(fit) if asked_of else {}
    return (*beaten, *(Doubt(q.of, q.why) for q in asked_of if matters(fit, q, tolerance, spread)))


def matters(fit: Fit, question: Question, tolerance: Pair, spread: Spread) -> bool:
    """Return whether a number as it may as well be makes anything that a user asks for farther off by the tolerance.

    Where no motion fits with it, it does: nothing is known then of what else would hold. `spread` is that of the fit.
    """
    model = replace(fit.model, fixed=dict(fit.model.fixed or {}) | {question.of: question.otherwise})
    state = replace(fit.state, values=fit.state.values | {question.of: question.otherwise})
    try:
        other = solve(model, state, fit.noise, fit.anchor, steps=SOLVER.refit_steps)
    except NotPositiveDefiniteError:
        return True
    time = times(fit)
    shift = moves_between(estimates_of(fit, time), estimates_of(other, time), fit.model.recording)
    return is_material(farther_off(shift, spread), tolerance)


def allowed(after: Weighed) -> float:
    """Return the misfit that noise may have on samples that are each predicted from all others."""
    return DECLARED_NOISE.held_out_misfit * (
        DECLARED_NOISE.misdeclared_power if any(level.declared is not None for level in after.levels) else 1.0
    )


def implausible(fit: Fit) -> tuple[Question, ...]:
    """Return numbers of effects that are far outside what their priors hold for plausible."""
    found = []
    for h in named_effects(fit):
        for p in h.effect.parameters:
            prior, value = fit.model.priors[h.key(p.name)], fit.state.values[h.key(p.name)]
            away = (value - prior.start) / prior.std
            off = float(np.max(away if p.name == DAMPING else np.abs(away)))
            if off > STATISTICS.rare_sigmas:
                least = -np.inf if p.name == DAMPING else -STATISTICS.rare_sigmas
                plausible = prior.start + prior.std * np.clip(away, least, STATISTICS.rare_sigmas)
                found.append(
                    Question(h.key(p.name), f"{off:.1f} standard deviations from what is plausible", plausible)
                )
    return tuple(found)


def halves_that_differ(fit: Fit) -> tuple[Question, ...]:
    """Return numbers in which the halves of the recording differ by more than chance and by more than serves."""
    _, white = information(fit)
    coloured = parameter_std(fit)
    named = {h.key(p.name) for h in named_effects(fit) for p in h.effect.parameters}
    logarithms = {h.key(p.name) for h in named_effects(fit) for p in h.effect.parameters if p.log}
    found = []
    for name, (apart, std) in halves(fit).items():
        if "@" in name and name not in named:
            continue  # of a term without a name: it may be anything
        wide = std * np.maximum(coloured[name] / white[name], 1.0)
        serves = (
            TRUST.serves
            if name in logarithms
            else TRUST.serves * np.linalg.norm(fit.state.values[name])
            if "@" in name
            else 0.0
        )
        serves = np.maximum(serves, SERVES_MOUNT.get(name.rpartition(".")[2], 0.0))
        beyond = np.abs(apart) / np.maximum(STATISTICS.rare_sigmas * wide, serves)
        k = int(np.argmax(beyond))
        if beyond[k] > 1:
            why = f"the halves of the recording differ by {apart[k]:.3g} +- {wide[k]:.2g}"
            found.append(Question(name, why, fit.state.values[name] + 0.5 * apart))
    return tuple(found)


def named_effects(fit: Fit) -> Iterator[Hypothesis]:
    """Yield the effects of a fit that have a name."""
    yield from (h for h in fit.model.hypotheses if not (isinstance(h.effect, Unknown) or h.effect.given))


@one_thread
def halves(fit: Fit) -> dict[str, tuple[Array, Array]]:
    """Return by how much every parameter (k,) differs between both halves of the recording, and the white-noise std."""
    start, end = fit.span
    model = fit.model
    rows = [(r, linearise(r, model.tracks, model.parameters)) for r in fit.rows]
    told = []
    for half in (0, 1):
        own = [part.of(block_of(r.time, start, end, np.inf, 2) == half) if is_data(r) else part for r, part in rows]
        normal = Normal.of(model.tracks, model.parameters, own)
        solution = solve_arrow(normal.band, normal.border, normal.corner)
        _, step = solution.solve(-normal.gradient[:, :, None], -normal.corner_gradient[:, None])
        told.append((step[:, 0], np.diag(np.linalg.inv(solution.schur))))
        del normal, solution  # with their factors: memory
    (one, variance1), (two, variance2) = told
    apart, std = two - one, np.sqrt(variance1 + variance2)
    columns = model.parameters.columns
    return {name: (apart[columns(name)], std[columns(name)]) for name in model.priors}


__all__ = ["allowed", "doubts", "halves", "halves_that_differ", "implausible"]
