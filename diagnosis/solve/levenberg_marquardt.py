"""The motion fit: Levenberg-Marquardt on splines and parameters together, noise levels estimated on the way."""

from dataclasses import dataclass, field
from weakref import WeakValueDictionary

from imubench.arrays import Array
from imubench.diagnosis.budget import check
from imubench.diagnosis.config.solve import ALGEBRA, SOLVER
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.residuals import Rows
from imubench.diagnosis.remembered import remembered
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import Step, all_rows, at_other_levels
from imubench.diagnosis.solve.retract import followed, moved, settled, with_centre_velocity
from imubench.diagnosis.solve.threads import one_thread


@dataclass(frozen=True, eq=False)
class Fit:
    """A model, its best state, and what the noise was taken to be; one is another's equal only if it is that."""

    model: Model
    state: State
    noise: dict[str, float]  # std of each group of rows, in its unit
    cost: float
    steps: int
    anchor: Array | None = None
    loose: float = 1.0
    rows: list[Rows] = field(default_factory=list, repr=False)

    @property
    def knots(self) -> int:
        """How many knots the splines have."""
        return self.model.tracks.knots.count

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the measurements, in s on the splines."""
        return min(float(r.time.min()) for r in self.measured), max(float(r.time.max()) for r in self.measured)

    @property
    def measured(self) -> list[Rows]:
        """The rows of measurements."""
        return [r for r in self.rows if r.counts]


_solved: WeakValueDictionary[int, Fit] = WeakValueDictionary()
"""A solution that ended at a state, by the state's identity, as long as somebody has it."""


def at_noise_of(fit: Fit, other: Fit) -> Fit:
    """Return a fit solved again at the noise levels of one with more in its model, to be compared with that."""
    return solve(
        fit.model, fit.state, {n: other.noise[n] for n in fit.noise}, fit.anchor, steps=SOLVER.steps_after_noise
    )


def converged(fit: Fit) -> Fit:
    """Return the fit at its least cost: what a search needs of it is less than what its numbers need.

    A skin's slide and the mount of its sensor move together by far at next to no cost: a fit may stop tens of nat above
    the least with numbers that are several standard deviations off.
    """
    return search(
        fit.model, fit.state, fit.noise, fit.anchor, SOLVER.fine_steps, SOLVER.fine_gain, SOLVER.free_damping
    )[0]


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
                if follow and length >= SOLVER.bent_length and trial_cost >= cost:
                    led = followed(model, trial, trial_rows, damping)
                    trial, trial_rows, trial_cost = _arrived(model, led, noise, anchor)
                if trial_cost < cost:
                    break
            else:
                damping *= 100
                continue
            state, rows, cost = trial, trial_rows, trial_cost
            damping = (
                max(damping / SOLVER.eased, SOLVER.least_damping)
                if length == SOLVER.lengths[0]
                else damping * SOLVER.eased
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


__all__ = ["Fit", "at_noise_of", "converged", "search", "solve"]
