"""Effects with states of their own, scored from one fit before any of them is fitted.

A law such as a spring's says what its state x does once the motion is known. The motion of the fit, without what of it
is noise, drives the law at each point of the effect's grid, one linear solve; the readings with that x in the model
less those without are one column, and what x does when a parameter moves are more. They are scored as any other
parameter's columns are. The motion itself is not driven back by x: good enough to choose what is fitted exactly and
where that begins.

A state without a law (play in a joint) is a spline more in the normal equations, at a few roughnesses; with the noise
as the fit leaves it and, where that is louder and so may hold what the state is, as it is declared.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import LAW
from imubench.diagnosis.config.shared import DECLARED_NOISE
from imubench.diagnosis.criteria.conditional_aic import aic_gain_of, linear_tally, tally
from imubench.diagnosis.criteria.effect_dynamics import solved_by_law, with_clear_motion
from imubench.diagnosis.criteria.trial import kind
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.problem.batch_model import Model, middles, started
from imubench.diagnosis.problem.bspline import Tracks
from imubench.diagnosis.problem.dynamics_factors import swing_rows
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import all_rows, at_other_levels
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.schur import Base, promise
from imubench.diagnosis.solve.threads import one_thread, side_by_side
from imubench.jets import derivatives_by


@dataclass(frozen=True)
class Screened:
    """What an effect with states promises, and where its fit should begin."""

    hypothesis: Hypothesis
    evidence: float  # nat
    values: dict[str, Array]  # parameters (k,)
    noise: dict[str, float]  # of a state without a law: its roughness, and the sensors' noise beside it
    amount: float = 1.0  # of the driven motion that the recording shows; 1 by the law
    best: Mapping[str, Array] | None = None  # parameters at the point that promises most


@one_thread
def screen(fit: Fit, hypotheses: list[Hypothesis]) -> list[Screened]:
    """Return what effects with states promise, best first; of one's variants without a law the best alone."""
    base = Base.of(fit)
    out = [
        s
        for h in hypotheses
        for s in [lawful_score(base, h) if h.effect.lawful else lawless_score(base, h)]
        if s is not None
    ]
    out.sort(key=lambda s: -s.evidence)
    return [s for s in out if s.hypothesis.effect.lawful or s is _plainest(s, out)]


def _plainest(one: Screened, out: list[Screened]) -> Screened:
    """Return, of the variants without a law of one's effect, the one with fewest states that promises nearly most."""
    same = [s for s in out if s.hypothesis.effect.free and kind(s.hypothesis) == kind(one.hypothesis)]
    good = [s for s in same if s.evidence >= same[0].evidence - LAW.fewer_states * abs(same[0].evidence)]
    return min(good, key=lambda s: sum(state.width for state in s.hypothesis.effect.states))


def lawful_score(base: Base, h: Hypothesis) -> Screened | None:
    """Return the best point of an effect whose states obey a law; None where the law has no solution.

    Its evidence is that of the best point; its fit begins at the point whose amount is nearest to the law's, or where a
    number of its own says how much of its drive there is, with that at the best one.
    """
    fit = base.fit
    start, end = fit.span
    calm = fit.state if h.effect.place != "imu" or h.effect.filters else with_clear_motion(fit, h.at)
    grid = points(h, end - start)

    def at_point(point: dict[str, float]) -> Screened | None:
        at, model = at_start(fit, h, point)
        names = [*(at.key(s.name) for s in h.effect.states), *(at.key(p.name) for p in h.effect.parameters)]
        with suppress(NotPositiveDefiniteError), derivatives_by(names):
            state, sensitivity = solved_by_law(model, started(model, fit.state), at, started(model, calm))
            return replace(_scored(base, model, state, sensitivity, at), hypothesis=h)
        return None

    found = [s for s in side_by_side(at_point, grid) if s is not None]
    if not found:
        return None
    best = max(found, key=lambda s: s.evidence)
    if h.effect.scale:
        drive = {h.key(h.effect.scale): np.log(np.full(1, max(best.amount, LAW.least_amount)))}
        return replace(best, values=best.values | drive)
    fair = [s for s in found if s.evidence >= LAW.fair * best.evidence] or found
    begin = min(fair, key=lambda s: abs(np.log(max(s.amount, 1e-3))))
    return replace(begin, evidence=best.evidence, best=best.values)


def _scored(base: Base, model: Model, state: State, sensitivity: Array, h: Hypothesis) -> Screened:
    """Return the score of the columns of a state that is driven by the fit's motion."""
    own = Tracks(model.tracks.knots, {h.key(s.name): s.width for s in h.effect.states})
    shared = Parameters({h.key(p.name): p.width for p in h.effect.parameters})
    k = 1 + shared.count
    moves = sensitivity.reshape(-1, own.width, shared.count) if own.width else sensitivity
    alone = {h.at} if h.effect.place == "imu" else set()
    measured = model.measured(state, alone) if h.effect.states else swing_rows(model, state, middles(model))
    columns = []
    for rows in measured:
        now = linearise(replace(rows, std=base.std_of(rows.name, rows.std)), own, shared)
        slopes = now.border + now.along(moves)
        change = now.residual - base.parts[rows.name].residual
        columns.append((rows.name, np.concatenate([change[:, :, None], slopes], axis=2)))
    schur, gradient = base.reduced(columns, k)
    prior = np.concatenate([[LAW.amount_std], *(np.full(p.width, p.std) for p in h.effect.parameters)])
    gradient[0] -= 1 / LAW.amount_std**2  # the law says 1
    found = promise(schur, gradient, prior)
    values = {name: state.values[name].copy() for name in shared.widths}
    return Screened(h, found.evidence - 0.5 / LAW.amount_std**2, values, {}, float(found.step[0]))


def lawless_score(base: Base, h: Hypothesis) -> Screened | None:
    """Return the best roughness of an effect whose states obey no law, and the noise with which it is that.

    One linear step each, weighed as a refit is: of a free state the evidence is about the motion's prior. Of the points
    of its grid the one that is best at a middling roughness.
    """
    fit = base.fit
    start, end = fit.span
    power = fit.model.averaging.power
    told = {
        n: std
        for n, std in declared(fit.model).items()
        if power(n, (fit.noise.get(n, 0.0) / std) ** 2) > DECLARED_NOISE.most_std**2
    }
    ways = ({}, told) if told else ({},)
    known = tally(fit)

    def begun(point: dict[str, float]) -> tuple[Model, State, list[Rows]]:
        """Return the model at a point with the state at nought, and its rows at levels that are not yet theirs."""
        _, model = at_start(fit, h, point)
        state = started(model, fit.state)
        noise = fit.noise | {f"smooth.{h.key(s.name)}": LAW.middle_roughness for s in h.effect.states}
        return model, state, all_rows(model, state, noise, fit.anchor, fit.loose)

    def at_level(start: tuple[Model, State, list[Rows]], levels: dict[str, float], rough: float) -> Screened | None:
        model, state, rows = start
        begin = levels | {f"smooth.{h.key(s.name)}": rough for s in h.effect.states}
        noise = fit.noise | begin
        with suppress(NotPositiveDefiniteError):
            seen = linear_tally(model, at_other_levels(model, state, rows, noise, fit.anchor, fit.loose))
            values = {h.key(p.name): state.values[h.key(p.name)].copy() for p in h.effect.parameters}
            return Screened(h, aic_gain_of(fit.noise, known, noise, seen), values, begin)
        return None

    grid = points(h, end - start)
    best = grid[0]
    if len(grid) > 1:
        promised = side_by_side(lambda point: _promise(at_level(begun(point), ways[-1], LAW.middle_roughness)), grid)
        best = grid[int(np.argmax(list(promised)))]
    at_best = begun(best)
    return max(side_by_side(lambda way: at_level(at_best, *way), product(ways, LAW.free_roughness)), key=_promise)


def points(h: Hypothesis, seconds: float) -> list[dict[str, float]]:
    """Return the points of an effect's grid in a recording of so many seconds; without one a point without numbers."""
    axes = h.effect.grid(seconds)
    return [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]


def at_start(fit: Fit, h: Hypothesis, point: dict[str, float]) -> tuple[Hypothesis, Model]:
    """Return an effect that starts at a point of its grid, and the fit's model with it."""
    at = replace(h, effect=h.effect.starting(**point)) if point else h
    return at, fit.model.with_effects((*fit.model.hypotheses, at))


def _promise(screened: Screened | None) -> float:
    return -np.inf if screened is None else screened.evidence


__all__ = ["Screened", "screen"]
