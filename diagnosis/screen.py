"""Effects with states of their own, scored from one fit before any of them is fitted.

A law such as a spring's says what its state x does once the motion is known. The motion of the fit drives the law
at each point of the effect's grid, one linear solve; the readings with that x in the model less those without are
one column, and what x does when a parameter moves are more. They are scored as any other parameter's columns are.
The motion itself is not driven back by x: good enough to choose what is fitted exactly and where that begins.

A state without a law (play in a joint) is a spline more in the normal equations, at a few roughnesses.
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.blocks import NotPositiveDefiniteError, Solution, solve_arrow
from imubench.diagnosis.equations import scenes, state_rows
from imubench.diagnosis.fit import Fit, all_rows, assemble
from imubench.diagnosis.model import Hypothesis, Model, State
from imubench.diagnosis.priors import middles
from imubench.diagnosis.rows import KNOTS_PER_BLOCK, Linear, Normal, Parameters, Rows, linearise
from imubench.diagnosis.score import started
from imubench.diagnosis.splines import SUPPORT, Moment, Tracks
from imubench.diagnosis.swings import swing_rows
from imubench.diagnosis.threads import one_thread
from imubench.jets import Jet

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
    rough: dict[str, float]  # roughness of its states, where it was tried
    amount: float = 1.0  # of the driven motion that the recording shows; 1 by the law


@dataclass(frozen=True)
class Base:
    """A fit's normal equations, factored once for all columns."""

    fit: Fit
    parts: dict[str, Linear]
    solution: Solution

    @classmethod
    def of(cls, fit: Fit) -> "Base":
        """Return the factored equations at the fit's state."""
        normal, linear = assemble(fit.model, fit.rows)
        named = {rows.name: part for rows, part in zip(fit.rows, linear, strict=True)}
        return cls(fit, named, solve_arrow(normal.band, normal.border, normal.corner))


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
    seconds = max(float(r.time[-1]) for r in fit.measured) - min(float(r.time[0]) for r in fit.measured)
    grid = [{name: value} for name, values in h.effect.grid(seconds).items() for value in values] or [{}]
    found = []
    for point in grid:
        at = replace(h, effect=h.effect.starting(**point)) if point else h
        model = fit.model.with_effects((*fit.model.hypotheses, at))
        with suppress(NotPositiveDefiniteError):
            state, sensitivity = obeyed(model, started(model, fit.state), at)
            found.append(replace(_scored(base, model, state, sensitivity, at), hypothesis=h))
    if not found:
        return None
    most = max(s.evidence for s in found)
    fair = [s for s in found if s.evidence >= FAIR * most] or found
    begin = min(fair, key=lambda s: abs(np.log(max(s.amount, 1e-3))))
    return replace(begin, evidence=most)


def obeyed(model: Model, state: State, h: Hypothesis) -> tuple[State, Array]:
    """Return the state with h's splines as its law says, and what they do (m, b, p) when a parameter moves."""
    own = Tracks(model.tracks.knots, {h.key(s.name): s.width for s in h.effect.states})
    shared = Parameters({h.key(p.name): p.width for p in h.effect.parameters})
    step = model.tracks.knots.step
    sensitivity = np.zeros(0)
    if not own.widths:
        return state, np.zeros((model.tracks.knots.count, 0, shared.count))
    state, passes = followed(model, state, h)
    for turn in range(passes):
        rows = [r for r in state_rows(model, state) if r.name.startswith(h.key(""))]
        normal = Normal.empty(own, shared)
        normal.add([linearise(r, own, shared) for r in rows])
        normal.fill(own)
        for s in h.effect.states:
            _held(normal, own, h.key(s.name), SMALL / s.std, step)
        factor = normal.band.factor()
        move = factor.solve(-normal.gradient[:, :, None]).reshape(-1, own.width)
        if turn + 1 == passes:
            sensitivity = -factor.solve(normal.border)
        coefficients = state.coefficients.copy()
        for name in own.widths:
            coefficients[:, model.tracks.columns(name)] += move[: own.knots.count, own.columns(name)]
        state = replace(state, coefficients=coefficients)
    return state, sensitivity


def followed(model: Model, state: State, h: Hypothesis) -> tuple[State, int]:
    """Return the state with h's splines where the effect itself says they are, and how many solves are left to do."""
    scene = next(scene for other, scene in scenes(model, state) if other == h)
    told = h.effect.follow(scene, model.values(h, state))
    if not told:
        return state, PASSES
    time, coefficients = middles(model), state.coefficients.copy()
    for name, value in told.items():
        own = Tracks(model.tracks.knots, {h.key(name): value.shape[1]})
        track = Moment(own, np.zeros((own.knots.count, own.width)), Jet(time[:, None])).track(h.key(name))
        normal = Normal.empty(own, Parameters({}))
        normal.add([linearise(Rows("follow", time, track - value, np.ones(own.width)), own, Parameters({}))])
        normal.fill(own)
        _held(normal, own, h.key(name), SMALL, 1.0)
        move = normal.band.factor().solve(-normal.gradient[:, :, None]).reshape(-1, own.width)
        coefficients[:, model.tracks.columns(h.key(name))] = move[: own.knots.count]
    return replace(state, coefficients=coefficients), 1


def _held(normal: Normal, tracks: Tracks, name: str, weight: float, step: float) -> None:
    """Hold a spline's coefficients weakly at zero."""
    b = normal.diagonal.shape[1]
    at = np.arange(b).reshape(-1, tracks.width)[:, tracks.columns(name)].reshape(-1)
    normal.diagonal[:, at, at] += step * weight**2


def _scored(base: Base, model: Model, state: State, sensitivity: Array, h: Hypothesis) -> Screened:
    """Return the score of the columns of a state that is driven by the fit's motion."""
    fit = base.fit
    own = Tracks(model.tracks.knots, {h.key(s.name): s.width for s in h.effect.states})
    shared = Parameters({h.key(p.name): p.width for p in h.effect.parameters})
    k = 1 + shared.count
    blocks, p = len(base.solution.factor.lower), fit.model.parameters.count
    cross, across = np.zeros((blocks * KNOTS_PER_BLOCK, fit.model.tracks.width, k)), np.zeros((p, k))
    corner, gradient = np.zeros((k, k)), np.zeros(k)
    moves = sensitivity.reshape(-1, own.width, shared.count) if own.width else sensitivity
    measured = model.measured(state) if h.effect.states else swing_rows(model, state, middles(model))
    for rows in measured:
        part = base.parts[rows.name]
        now = linearise(replace(rows, std=rows.std * fit.noise[rows.name] * fit.loose), own, shared)
        slopes = now.border + np.einsum("nmsw,nswp->nmp", now.local, moves[now.first[:, None] + np.arange(SUPPORT)])
        columns = np.concatenate([(now.residual - part.residual)[:, :, None], slopes], axis=2)
        part.scatter(columns, cross)
        flat = columns.reshape(-1, k)
        across += part.border.reshape(-1, p).T @ flat
        corner += flat.T @ flat
        gradient += flat.T @ part.residual.reshape(-1)
    schur = base.solution.complement(cross.reshape(blocks, -1, k), across, corner)
    prior = np.concatenate([[AMOUNT], *(np.full(p.width, p.std) for p in h.effect.parameters)])
    matrix = schur * np.outer(prior, prior) + np.eye(k)
    pull = gradient * prior
    pull[0] -= 1 / AMOUNT  # the law says 1
    move = -np.linalg.solve(matrix, pull)
    evidence = -0.5 * float(move @ pull) - 0.5 / AMOUNT**2 - 0.5 * float(np.linalg.slogdet(matrix)[1])
    move = move * prior
    values = {name: state.values[name].copy() for name in shared.widths}
    return Screened(h, evidence, values, {}, float(move[0]))


def free(base: Base, h: Hypothesis) -> Screened | None:
    """Return the best roughness of an effect whose states obey no law."""
    fit = base.fit
    model = fit.model.with_effects((*fit.model.hypotheses, h))
    state = started(model, fit.state)
    best, before = None, _log_det(base.solution)
    names = [h.key(s.name) for s in h.effect.states]
    for rough in ROUGH:
        chosen = {f"smooth.{name}": rough for name in names}
        rows = all_rows(model, state, fit.noise | chosen, fit.anchor, fit.loose)
        normal, _ = assemble(model, rows)
        try:
            solution = solve_arrow(normal.band, normal.border, normal.corner)
        except NotPositiveDefiniteError:
            continue
        x, p = solution.solve(-normal.gradient[:, :, None], -normal.corner_gradient[:, None])
        gain = -0.5 * float(np.sum(x[:, :, 0] * normal.gradient) + p[:, 0] @ normal.corner_gradient)
        own = Tracks(model.tracks.knots, {name: model.tracks.widths[name] for name in names})
        prior = Normal.empty(own, Parameters({}))
        theirs = [r for r in rows if not r.counts and any(n in names for n, _ in r.residual.blocks)]
        prior.add([linearise(r, own, Parameters({})) for r in theirs])
        prior.fill(own)
        price = 0.5 * (_log_det(solution) - before) - float(np.log(_diagonal(prior)).sum())
        if best is None or gain - price > best.evidence:
            best = Screened(h, gain - price, {}, chosen)
    return best


def _diagonal(normal: Normal) -> Array:
    return np.diagonal(normal.band.factor().lower, axis1=1, axis2=2)


def _log_det(solution: Solution) -> float:
    """Return the log determinant of the whole arrow matrix."""
    diagonal = np.diagonal(solution.factor.lower, axis1=1, axis2=2)
    return 2 * float(np.log(diagonal).sum()) + float(np.linalg.slogdet(solution.schur)[1])


__all__ = ["Screened", "screen"]
