"""The motion fit: Levenberg-Marquardt on splines and parameters together, noise levels estimated on the way."""

from contextlib import suppress
from weakref import WeakValueDictionary

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.budget import check
from imubench.diagnosis.config.solve import ALGEBRA, SOLVER
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import Tracks
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.motion_prior import pace_rows
from imubench.diagnosis.problem.residuals import Rows
from imubench.diagnosis.problem.rig_kinematics import VELOCITY
from imubench.diagnosis.remembered import remembered
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import Step, all_rows, assemble, at_other_levels, own_rows
from imubench.diagnosis.solve.narrow_band import eased
from imubench.diagnosis.solve.retract import moved, shifted
from imubench.diagnosis.solve.threads import one_thread
from imubench.jets import derivatives_by

_solved: WeakValueDictionary[int, Fit] = WeakValueDictionary()
"""A solution that ended at a state, by the state's identity, as long as somebody has it."""


def at_noise_of(fit: Fit, other: Fit) -> Fit:
    """Return a fit solved again at the noise levels of one with more in its model, to be compared with that."""
    return solve(fit.model, fit.state, {n: other.noise[n] for n in fit.noise}, fit.anchor, steps=SOLVER.few_steps)


def converged(fit: Fit) -> Fit:
    """Return the fit at its least cost: what a search needs of it is less than what its numbers need.

    A skin's slide and the mount of its sensor move together by far at next to no cost: a fit may stop tens of nat above
    the least with numbers that are several standard deviations off.
    """
    return search(fit.model, fit.state, fit.noise, fit.anchor, SOLVER.steps, SOLVER.fine_gain, ALGEBRA.ridge)[0]


@remembered
def solve(
    model: Model,
    state: State,
    noise: dict[str, float],
    anchor: Array | None = None,
    steps: int = SOLVER.steps,
    enough: float = SOLVER.least_gain,
) -> Fit:
    """Return the state of least cost, from `state`."""
    return search(model, state, noise, anchor, steps, enough)[0]


@one_thread
def search(
    model: Model,
    state: State,
    noise: dict[str, float],
    anchor: Array | None = None,
    steps: int = SOLVER.steps,
    enough: float = SOLVER.least_gain,
    damping: float = ALGEBRA.damped,
) -> tuple[Fit, Step | None]:
    """Return the state of least cost, from `state`, and the step that led to it, where one did.

    With a `damping` below the usual one it takes long steps in what moves together, and the splines follow these.
    """
    taken, follow, step = 0, damping < ALGEBRA.damped, None
    rows = _rows_at(model, state, noise, anchor)
    cost = sum(r.cost for r in rows)
    least = enough * sum(r.residual.value.size for r in rows if r.counts)
    while taken < steps:
        taken += 1
        before, step = cost, None
        while damping < SOLVER.most_damping:
            check()
            try:
                step = Step.of(model, rows, damping)
            except NotPositiveDefiniteError:
                damping *= 10
                continue
            for length in SOLVER.lengths:
                check()
                led = moved(model, state, length * step.splines, length * step.values)
                trial, trial_rows, trial_cost = _arrived(model, led, noise, anchor)
                if follow and length > SOLVER.lengths[-1] and trial_cost >= cost:
                    led = followed(model, trial, trial_rows, damping)
                    trial, trial_rows, trial_cost = _arrived(model, led, noise, anchor)
                if trial_cost < cost:
                    break
            else:
                damping *= 100
                continue
            state, rows, cost = trial, trial_rows, trial_cost
            damping = (
                max(damping / SOLVER.eased, ALGEBRA.ridge) if length == SOLVER.lengths[0] else damping * SOLVER.eased
            )
            break
        gained = before - cost
        if gained < least or (step and abs(gained - step.promised) < SOLVER.foretold * least):
            break
    fit = Fit(model, state, noise, cost, taken, anchor, rows=rows)
    if _known(model, state) is None:
        _solved[id(state)] = fit
    return fit, step


def _rows_at(model: Model, state: State, noise: dict[str, float], anchor: Array | None) -> list[Rows]:
    """Return all rows at a state; where a fit is still there that ended at it, those of its that hold."""
    known = _known(model, state)
    if known is None:
        return all_rows(model, state, noise, anchor)
    return at_other_levels(model, state, known.rows, noise, anchor)


def _known(model: Model, state: State) -> Fit | None:
    """Return a solution that ended at a state and has the rows of a model."""
    known = _solved.get(id(state))
    return known if known is not None and known.state is state and known.model.same_rows(model) else None


def _arrived(
    model: Model, state: State, noise: dict[str, float], anchor: Array | None
) -> tuple[State, list[Rows], float]:
    """Return where a step has led once what follows from the rest is solved for, with its rows and its cost."""
    state = settled(model, with_centre_velocity(model, state), noise)
    rows = all_rows(model, state, noise, anchor)
    return state, rows, sum(r.cost for r in rows)


def followed(model: Model, state: State, rows: list[Rows], damping: float) -> State:
    """Return a state whose splines follow the parameters that a step led to: what it left of second order is gone.

    What a step leaves of second order may exceed what it gains, as of a mount's turn beside a skin that slides. Where
    nothing holds a spline all stay.
    """
    normal, _ = assemble(model, rows)
    normal.damp(damping)
    with suppress(NotPositiveDefiniteError):
        x = normal.band.factor().solve(-normal.gradient[:, :, None])
        return moved(model, state, x[:, :, 0], np.zeros(model.parameters.count))
    return state


def with_centre_velocity(model: Model, state: State) -> State:
    """Return the state with the joint centre's velocity solved for everything else as it is.

    It is an integral of attitude and force, held tightly, and linear: what a step leaves of second order in it cost
    more than the step had gained, so that steps were cut to fifths.
    """
    if VELOCITY not in model.tracks.widths:
        return state
    only = Tracks(model.tracks.knots, {VELOCITY: model.tracks.widths[VELOCITY]})
    with derivatives_by(only.widths):
        rows = list(pace_rows(model, state))
    return shifted(model, state, only, eased(only, rows, ALGEBRA.damped))


def settled(model: Model, state: State, noise: dict[str, float], loose: float = 1.0) -> State:
    """Return the state with the effects' own splines solved for everything else as it is.

    A spring's law is tight and nearly linear in what hangs on it, but not in both it and the spring's constants:
    without this a step in a frequency breaks the law and is taken back.
    """
    own = {h.key(s.name): s.width for h in model.hypotheses for s in h.effect.states}
    if not own:
        return state
    only = Tracks(model.tracks.knots, own)
    size = np.concatenate([np.full(s.width, s.std) for h in model.hypotheses for s in h.effect.states])
    places = {h.at for h in model.hypotheses if h.effect.states}
    alone = places if places <= {imu.name for imu in model.recording.imus} else ()  # a joint's states move all sensors
    for _ in range(ALGEBRA.spline_solves):
        change = eased(only, own_rows(model, state, noise, loose, alone, own), ALGEBRA.damped)
        state = shifted(model, state, only, change)
        if np.max(np.abs(change) / size) < ALGEBRA.moved:
            break
    return state


__all__ = ["at_noise_of", "converged", "search", "settled", "solve"]
