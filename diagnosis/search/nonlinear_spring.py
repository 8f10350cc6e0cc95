"""Springs whose stiffness depends on how far they are pushed: an effect that is found but has no name in the table.

A law of straight springs, f + 2 z w x' + w^2 x = 0, holds only up to the noise that the fit gives it; foam that
stiffens leaves more, and the springs' state takes it in as a spline would. So each is fitted once more with a force of
w^2 x (1 + b (q - 1)), q about x^2 / s^2, on every axis, s the size of its state: w is the frequency at a usual push.
Where that predicts the samples better than straight springs do, at the noise that each leaves, the law has left
something out.

Left-out data are predicted by one linear step, and the freedoms that springs of another frequency give are worth tens
of nat, so a mount that hardens may still lose there. So the distance of b from 0 (Savage and Dickey) counts instead if
it is more and the samples are no worse for it.

What a bend promises is half a chi-square with 3 degrees of freedom where the springs are straight. Beyond
`EVIDENCE.needed_nat`, as 2 % of straight springs are, their name is in doubt: some mounts that harden promise little
more, and no straight one can be shown to be straight. From `LIKELY` on, which straight springs reach in two of a
thousand, a soft mount's bend is reported as well, with low confidence. A rocking mount's is only doubted: it promises
much also where a fit has not settled. Beyond `EVIDENCE.clear_nat` springs that bend are fitted.

The bias of springs by noise (`debiased_fit`) looks like a bend too, so the promise is the smaller one of before and
after it is removed; a bend is fitted after. The figures behind this are in lab/019.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import CONFIDENCE, EVIDENCE, STATISTICS
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.cross_validation import predicted
from imubench.diagnosis.criteria.trial import Gain
from imubench.diagnosis.noise.debiased_fit import debiased
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.motion_prior import states_inside
from imubench.diagnosis.problem.residuals import CHANNELS
from imubench.diagnosis.residual_checks.excess_noise import unexplained
from imubench.diagnosis.residual_checks.localize import shares
from imubench.diagnosis.result import Finding, Parameter, Where
from imubench.diagnosis.search.confidence import confidence, nameless
from imubench.diagnosis.search.moves.drop import at_centre
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import all_rows, extended, factored
from imubench.diagnosis.solve.levenberg_marquardt import at_noise_of
from imubench.diagnosis.solve.refit import information, refit
from imubench.effects.effect import Effect

LIKELY = 7.5  # nat that a bend of a soft mount promises, from which on it is said too
NEEDED = 20.0  # nat, before springs are believed to bend; what they gain on held-out data only has to be a gain
CLEAR = 25.0  # nat by which b is not 0: so much needs no left-out data
BEND_NOISE_ROUNDS = 4  # of the noise's estimation, the law's own with it


@dataclass(frozen=True)
class NonlinearSprings:
    """Springs that bend, in the place of straight ones."""

    hypothesis: Hypothesis  # the straight ones
    before: Fit  # with these
    fit: Fit  # with the others
    evidence: float  # nat
    heldout: Gain
    bend: Parameter  # (3,) b
    clear: bool  # whether b is so far from 0 that left-out data need not be asked


def nonlinear_springs(
    fit: Fit, say: Callable[[str], None] = lambda _: None
) -> tuple[list[NonlinearSprings], dict[Hypothesis, float]]:
    """Return the springs of a fit that bend, each in a fit with those before, and all that are not surely straight.

    Of these with the nat that a bend promises.
    """
    out: list[NonlinearSprings] = []
    unsure: dict[Hypothesis, float] = {}
    for h, springs in straight(fit):
        say(f"looking whether the springs of {h.name} bend")
        with suppress(NotPositiveDefiniteError):
            promise = promised(fit, h, springs)
            if promise < EVIDENCE.needed_nat:
                continue
            pulled = debiased(fit)
            promise = min(promise, promised(pulled, h, springs))
            if promise > EVIDENCE.needed_nat:
                unsure[h] = promise
            if promise < EVIDENCE.clear_nat:
                continue
            found = bending(pulled, h, springs)
            if found.clear or (found.evidence > NEEDED and found.heldout.value > 0):
                out, fit = [*out, found], found.fit
    return out, unsure


def straight(fit: Fit) -> list[tuple[Hypothesis, Effect]]:
    """Return the mounts of a fit that are on straight springs."""
    return [(h, h.effect) for h in fit.model.hypotheses if h.effect.straight_springs]


def promised(fit: Fit, h: Hypothesis, springs: Effect) -> float:
    """Return the nat that a small bend promises, everything else free to follow; straight springs have their slope."""
    curved, everything = in_place(fit, h, springs)
    begun = extended(fit, everything)
    rows = all_rows(begun.model, begun.state, begun.noise, begun.anchor, begun.loose)
    normal, solution, _ = factored(begun.model, rows)
    places = begun.model.parameters.places([curved.key("bend")])
    information, slope = solution.reduced(normal.gradient, normal.corner_gradient, places)
    return 0.5 * float(slope @ np.linalg.solve(information, slope))


def in_place(fit: Fit, h: Hypothesis, springs: Effect) -> tuple[Hypothesis, tuple[Hypothesis, ...]]:
    """Return springs that bend, and all effects of a fit with these in the place of the straight ones."""
    (state,) = springs.states
    moved = states_inside(fit.model, fit.state, h)[state.name]
    size = np.sqrt(np.mean(moved**2, axis=0)) + 1e-4 * state.std
    curved = replace(h, effect=springs.bending(size))
    return curved, tuple(curved if other == h else other for other in fit.model.hypotheses)


def bending(fit: Fit, h: Hypothesis, springs: Effect) -> NonlinearSprings:
    """Return a fit with springs that bend, and what it is worth over the one with straight ones."""
    curved, everything = in_place(fit, h, springs)
    tried = refit(fit, everything)
    better = with_noise(tried, BEND_NOISE_ROUNDS)
    before = with_noise(fit, BEND_NOISE_ROUNDS)
    heldout = predicted(at_noise_of(before, better), better, np.random.default_rng(STATISTICS.seed))
    bend = curved.key("bend")
    covariance, std = information(better)
    stiffer = Parameter(better.state.values[bend], std[bend], "1")
    nat = aic_gain(before, better)
    away = at_centre(better, [bend], covariance) if nat > 0 else -np.inf
    return NonlinearSprings(h, before, better, max(nat, away), heldout, stiffer, away > CLEAR)


def nonlinear_finding(found: NonlinearSprings) -> Finding:
    """Return springs that bend as a finding without a name, at the channels in which they explain more."""
    at = found.hypothesis.at
    before = {r.name: r.whitened for r in found.before.measured}
    where = _where(at, {r.name: r.whitened - before[r.name] for r in found.fit.measured})
    return nameless(at, confidence(found.evidence, NEEDED), {"stiffening": found.bend}, found.heldout, where)


def suspected_findings(unsure: Mapping[Hypothesis, float], fit: Fit) -> list[Finding]:
    """Return soft mounts of a fit that likely bend as findings without a name; `unsure`: what each promises, in nat."""
    likely = [h for h, promise in unsure.items() if promise > LIKELY and not h.effect.rocks]
    return [replace(left_by(h, fit), confidence=CONFIDENCE.doubtful) for h in likely if h in fit.model.hypotheses]


def unheld(fit: Fit) -> list[Hypothesis]:
    """Return the springs of a fit that leaves more than noise can be: their law is not all there is to them.

    Straight ones leave about the noise.
    """
    springs = [h for h, _ in straight(fit)]
    return springs if springs and misfit(fit, at_least=True) > ADMISSION.unexplained_misfit else []


def left_by(h: Hypothesis, fit: Fit) -> Finding:
    """Return what springs leave as a finding without a name."""
    return unexplained(_where(h.at, {r.name: r.whitened for r in fit.measured}))


def _where(at: str, whitened: dict[str, Array]) -> Where:
    """Return a place by the power of residuals (n, 3) in the channels of its sensor."""
    power = {
        channel: float(np.sum(x[:, i] ** 2))
        for name, x in whitened.items()
        for i, channel in enumerate(CHANNELS.get(name.split(".")[1], ()))
        if name.split(".")[0] == at
    }
    return Where(at, shares(power), (), (), "how far its springs are pushed: they are not straight", 1.0)


__all__ = [
    "NonlinearSprings",
    "bending",
    "left_by",
    "nonlinear_finding",
    "nonlinear_springs",
    "suspected_findings",
    "unheld",
]
