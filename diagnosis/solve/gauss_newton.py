"""All rows of the motion fit, with effects that come in, their normal equations, and the step that these ask for."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import LAW
from imubench.diagnosis.config.solve import START
from imubench.diagnosis.problem.batch_model import Model, middles, started
from imubench.diagnosis.problem.dynamics_factors import swing_rows
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.motion_prior import is_prior, prior_rows, size_rows, smooth_rows
from imubench.diagnosis.problem.process_factors import state_rows
from imubench.diagnosis.problem.residuals import Rows
from imubench.diagnosis.solve.bordered import Solution, solve_arrow
from imubench.diagnosis.solve.linearize import Linear, linearise
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.jets import derivatives_by


def all_rows(
    model: Model,
    state: State,
    noise: dict[str, float],
    anchor: Array | None,
    loose: float = 1.0,
    alone: Collection[str] = (),
) -> list[Rows]:
    """Return every row of the problem, or of all sensors some IMUs' alone; `loose` widens the measurements' noise."""
    return [*_asked(model, state, noise, loose, alone), *prior_rows(model, state, noise, anchor)]


def _asked(model: Model, state: State, noise: dict[str, float], loose: float, alone: Collection[str]) -> Iterator[Rows]:
    """Yield the rows of measurements and laws."""
    yield from (r.at_level(noise[r.name] * loose) for r in model.measured(state, alone))
    yield from (r.at_level(noise.get(r.name, 1.0) * loose) for r in equation_rows(model, state))


def own_rows(
    model: Model, state: State, noise: dict[str, float], loose: float, alone: Collection[str], own: Collection[str]
) -> list[Rows]:
    """Return the rows that depend on some states of effects, with derivatives by these splines alone."""
    with derivatives_by(own):
        rows = (*_asked(model, state, noise, loose, alone), *smooth_rows(model, state, noise, own))
        return [r for r in (*rows, *size_rows(model, state)) if r.residual.blocks]


def at_other_levels(
    model: Model,
    state: State,
    known: Sequence[Rows],
    noise: dict[str, float],
    anchor: Array | None,
    loose: float = 1.0,
) -> list[Rows]:
    """Return every row of the problem at other noise levels than those `known` at this state; priors are made anew."""
    kept = [r.at_level(noise.get(r.name, 1.0) * loose) for r in known if not is_prior(r)]
    return kept + list(prior_rows(model, state, noise, anchor))


def assemble(model: Model, rows: list[Rows]) -> tuple[Normal, list[Linear]]:
    """Return the normal equations and the rows that made them."""
    linear = [linearise(r, model.tracks, model.parameters) for r in rows]
    return Normal.of(model.tracks, model.parameters, linear), linear


def factored(model: Model, rows: list[Rows]) -> tuple[Normal, Solution, list[Linear]]:
    """Return the normal equations, their band gone into the factored ones beside them, and the rows that made them."""
    normal, linear = assemble(model, rows)
    return normal, solve_arrow(normal.band, normal.border, normal.corner), linear


@dataclass(frozen=True)
class Step:
    """A damped Gauss-Newton step, and the factored equations that it was solved from."""

    splines: Array  # (blocks, b)
    values: Array  # (p,)
    promised: float  # of the cost
    damping: float
    solution: Solution
    linear: list[Linear]

    @classmethod
    def of(cls, model: Model, rows: list[Rows], damping: float = 0.0) -> "Step":
        """Return the step that rows ask for."""
        normal, linear = assemble(model, rows)
        normal.damp(damping)
        corner = normal.corner + damping * np.diag(np.diag(normal.corner))
        solution = solve_arrow(normal.band, normal.border, corner)
        x, values = solution.solve(-normal.gradient[:, :, None], -normal.corner_gradient[:, None])
        promised = -0.5 * float(np.vdot(normal.gradient, x) + normal.corner_gradient @ values[:, 0])
        return cls(x[:, :, 0], values[:, 0], promised, damping, solution, linear)


def equation_rows(model: Model, state: State) -> Iterator[Rows]:
    """Yield the rows of every law; none is a measurement."""
    yield from state_rows(model, state)
    yield from swing_rows(model, state, middles(model))


def extended(fit: Fit, hypotheses: tuple[Hypothesis, ...], guess: dict[str, Array] | None = None) -> Fit:
    """Return the fit's state in a model with these effects, parameters at `guess` or their start, not yet solved."""
    model = fit.model.with_effects(hypotheses)
    state = started(model, _kept(fit, model))
    state = State(state.coefficients, state.values | (guess or {}))
    noise = dict(fit.noise)
    for h in hypotheses:
        for s in h.effect.states:
            noise.setdefault(
                f"smooth.{h.key(s.name)}",
                START.lawful_state_roughness * s.std if h.effect.lawful else LAW.middle_roughness,
            )
    for rows in equation_rows(model, state):
        noise.setdefault(rows.name, 1.0)
    return replace(fit, model=model, state=state, noise=noise)


def _kept(fit: Fit, model: Model) -> State:
    """Return the state with the splines and parameters that `model` still has, in its order."""
    old = fit.model.tracks
    kept = [fit.state.coefficients[:, old.columns(n)] for n in model.tracks.widths if n in old.widths]
    values = {n: v for n, v in fit.state.values.items() if n in model.priors}
    return State(np.concatenate(kept, axis=1), values)


def guess_of(h: Hypothesis, estimate: Array) -> dict[str, Array]:
    """Return a score's estimate (k,) by parameter name."""
    out, at = {}, 0
    for p in h.effect.parameters:
        out[h.key(p.name)] = estimate[at : at + p.width]
        at += p.width
    return out
