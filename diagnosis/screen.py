"""Effects with states of their own, scored from one fit before any of them is fitted.

A law such as a spring's says what its state x does once the motion is known. The motion of the fit drives the law
at each point of the effect's grid, one linear solve; the readings with that x in the model less those without are
one column, and what x does when a parameter moves are more. They are scored as any other parameter's columns are.
The motion itself is not driven back by x: good enough to choose what is fitted exactly and where that begins.

A state without a law (play in a joint) is a spline more in the normal equations, at a few roughnesses; with the noise
as the fit leaves it and, where that is louder and so may hold what the state is, as it is declared.
"""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.blocks import NotPositiveDefiniteError
from imubench.diagnosis.columns import Base, promise
from imubench.diagnosis.equations import scenes, state_rows
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.hypothesis import Hypothesis, State
from imubench.diagnosis.linear import linearise
from imubench.diagnosis.model import Model
from imubench.diagnosis.narrow import solved
from imubench.diagnosis.noise import declared
from imubench.diagnosis.normal import Normal
from imubench.diagnosis.priors import inside, middles
from imubench.diagnosis.raw_findings import DECLARED
from imubench.diagnosis.rows import Parameters, Rows
from imubench.diagnosis.score import started
from imubench.diagnosis.settle import shifted
from imubench.diagnosis.splines import Moment, Tracks
from imubench.diagnosis.swings import swing_rows
from imubench.diagnosis.system import all_rows
from imubench.diagnosis.threads import one_thread, side_by_side
from imubench.diagnosis.worth import foreseen, tallied, won
from imubench.jets import Jet, derivatives_by

SMALL = 1e-3  # of its plausible size: how weakly a driven state is held where its law says little
ROUGH = (1e2, 1e3, 1e4, 1e5)  # of a free state, in its unit per s^4 and root Hz
AMOUNT = 0.3  # std about 1 of the share of a driven motion that a recording shows: the fit has taken in some of it
FAIR = 0.3  # of the best point's promise: of such points that comes first whose amount is nearest to 1
PASSES = 2  # solves of a law, the second where the first has led


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
    """Return what effects with states promise, best first."""
    base = Base.of(fit)
    out = [s for h in hypotheses for s in [driven(base, h) if h.effect.lawful else free(base, h)] if s is not None]
    return sorted(out, key=lambda s: -s.evidence)


def driven(base: Base, h: Hypothesis) -> Screened | None:
    """Return the best point of an effect whose states obey a law; None where the law has no solution.

    Its evidence is that of the best point; its fit begins at the point whose amount is nearest to the law's.
    """
    fit = base.fit
    start, end = fit.span
    grid = [{name: value} for name, values in h.effect.grid(end - start).items() for value in values] or [{}]

    def at_point(point: dict[str, float]) -> Screened | None:
        at = replace(h, effect=h.effect.starting(**point)) if point else h
        model = fit.model.with_effects((*fit.model.hypotheses, at))
        own = [*(at.key(s.name) for s in h.effect.states), *(at.key(p.name) for p in h.effect.parameters)]
        with suppress(NotPositiveDefiniteError), derivatives_by(own):
            state, sensitivity = obeyed(model, started(model, fit.state), at)
            return replace(_scored(base, model, state, sensitivity, at), hypothesis=h)
        return None

    found = [s for s in side_by_side(at_point, grid) if s is not None]
    if not found:
        return None
    best = max(found, key=lambda s: s.evidence)
    fair = [s for s in found if s.evidence >= FAIR * best.evidence] or found
    begin = min(fair, key=lambda s: abs(np.log(max(s.amount, 1e-3))))
    return replace(begin, evidence=best.evidence, best=best.values)


def obeyed(model: Model, state: State, h: Hypothesis) -> tuple[State, Array]:
    """Return the state with h's splines as its law says, and what they do (m, b, p) when a parameter moves."""
    own = Tracks(model.tracks.knots, {h.key(s.name): s.width for s in h.effect.states})
    shared = Parameters({h.key(p.name): p.width for p in h.effect.parameters})
    step = model.tracks.knots.step
    if not own.widths:
        return state, np.zeros((model.tracks.knots.count, 0, shared.count))
    state, passes = followed(model, state, h)
    for turn in range(passes):
        normal = Normal.empty(own, shared)
        normal.add([linearise(r, own, shared) for r in state_rows(model, state, h)])
        normal.fill(own)
        for s in h.effect.states:
            _held(normal, own, h.key(s.name), SMALL / s.std, step)
        last = turn + 1 == passes
        asked = [normal.gradient[:, :, None], normal.border] if last else [normal.gradient[:, :, None]]
        moves = -solved(normal, np.concatenate(asked, axis=2))
        sensitivity = moves[:, :, 1:]
        state = shifted(model, state, own, moves[:, :, 0].reshape(-1, own.width))
    return state, sensitivity


def led(model: Model, state: State, hypotheses: Iterable[Hypothesis]) -> State:
    """Return the state with the splines of effects that obey a law as the motion drives them."""
    for h in hypotheses:
        if h.effect.lawful:
            state = obeyed(model, state, h)[0]
    return state


def followed(model: Model, state: State, h: Hypothesis) -> tuple[State, int]:
    """Return the state with h's splines where the effect itself says they are, and how many solves are left to do."""
    ((_, scene),) = scenes(model, state, h)
    told = h.effect.follow(scene, model.values(h, state))
    if not told:
        return state, PASSES
    time, coefficients = inside(model), state.coefficients.copy()
    for name, value in told.items():
        own = Tracks(model.tracks.knots, {h.key(name): value.shape[1]})
        track = Moment(own, np.zeros((own.knots.count, own.width)), Jet(time[:, None])).track(h.key(name))
        normal = Normal.empty(own, Parameters({}))
        normal.add([linearise(Rows("follow", time, track - value, np.ones(own.width)), own, Parameters({}))])
        normal.fill(own)
        _held(normal, own, h.key(name), SMALL, 1.0)
        move = -solved(normal, normal.gradient[:, :, None]).reshape(-1, own.width)
        coefficients[:, model.tracks.columns(h.key(name))] = move[: own.knots.count]
    return replace(state, coefficients=coefficients), 1


def _held(normal: Normal, tracks: Tracks, name: str, weight: float, step: float) -> None:
    """Hold a spline's coefficients weakly at zero."""
    b = normal.diagonal.shape[1]
    at = np.arange(b).reshape(-1, tracks.width)[:, tracks.columns(name)].reshape(-1)
    normal.diagonal[:, at, at] += step * weight**2


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
    prior = np.concatenate([[AMOUNT], *(np.full(p.width, p.std) for p in h.effect.parameters)])
    gradient[0] -= 1 / AMOUNT**2  # the law says 1
    found = promise(schur, gradient, prior)
    values = {name: state.values[name].copy() for name in shared.widths}
    return Screened(h, found.evidence - 0.5 / AMOUNT**2, values, {}, float(found.step[0]))


def free(base: Base, h: Hypothesis) -> Screened | None:
    """Return the best roughness of an effect whose states obey no law, and the noise with which it is that.

    One linear step each, weighed as a refit is: of a free state the evidence is about the motion's prior.
    """
    fit = base.fit
    model = fit.model.with_effects((*fit.model.hypotheses, h))
    state = started(model, fit.state)
    names = [f"smooth.{h.key(s.name)}" for s in h.effect.states]
    told = {n: std for n, std in declared(fit.model).items() if DECLARED * std < fit.noise.get(n, 0.0)}
    known, best = tallied(fit), None
    for levels in ({}, told) if told else ({},):
        for rough in ROUGH:
            start = levels | dict.fromkeys(names, rough)
            noise = fit.noise | start
            try:
                seen = foreseen(model, all_rows(model, state, noise, fit.anchor, fit.loose))
            except NotPositiveDefiniteError:
                continue
            evidence = won(fit.noise, known, noise, seen)
            if best is None or evidence > best.evidence:
                best = Screened(h, evidence, {}, start)
    return best


__all__ = ["Screened", "led", "screen"]
