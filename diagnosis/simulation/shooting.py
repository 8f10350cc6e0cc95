"""Numbers that roll-outs show: multiple shooting over free swings.

The equation of motion, asked once between two knots, knows a mount's rotation to a milliradian: a spline motion that is
free to follow every sample takes up what a wrong mount does to it. A roll-out has no such freedom: what a wrong number
does to it grows over the window, and at 10 rad/s a milliradian is ten times a gyroscope's noise. So in windows that are
rolled out numbers p come from the roll-outs themselves, with a state s_w at the start of each. They minimise

    sum over windows w of |simulated(p, s_w) - measured|^2 / noise^2  +  (p - p0)' K (p - p0)

K and p0 are what priors and all other samples that may teach say: the equations of the motion fit without the rows in
the windows. With r = simulated - measured over the noise, S and A its derivatives by s_w and p, and P = 1 - S S^+ what
no state takes up, a step of Gauss and Newton obeys

    (K + sum A' P A) dp = -(K (p - p0) + sum A' P r)        ds_w = -S^+ (r + A dp)

and promises to lower the sum by  sum |S S^+ r|^2 - dp' (K (p - p0) + sum A' P r).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.noise import DEBIAS
from imubench.diagnosis.config.simulation import ROLL_OUT
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.criteria.cross_validation import half_step
from imubench.diagnosis.evidence import Swing
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import is_data
from imubench.diagnosis.simulation.learned import numbers_of
from imubench.diagnosis.simulation.rollout import Misfit, best_step, slopes, state_beside
from imubench.diagnosis.simulation.sim_model import SimModel, sim_model
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.diagnosis.windows import covered
from imubench.errors import InputError


@dataclass(frozen=True)
class Known:
    """What priors, and samples that are not rolled out, say of the numbers."""

    numbers: Array  # (p,)
    information: Array  # (p, p)


@dataclass(frozen=True)
class Shot:
    """Numbers (p,), windows with the states at their starts, and how far the roll-outs are off."""

    numbers: Array
    windows: tuple[Swing, ...]
    off: tuple[Array, ...]  # (n,) by window, over the noise
    cost: float  # squared residuals over the noise, and what is known otherwise


@dataclass(frozen=True)
class Slopes:
    """Derivatives of every window's misfit: by the state at its start, and by the numbers that are free."""

    state: tuple[Array, ...]  # (n, 2 or 6)
    numbers: tuple[Array, ...]  # (n, free)


@dataclass(frozen=True)
class Step:
    """A step of Gauss and Newton."""

    numbers: Array  # (p,)
    states: tuple[Array, ...]  # (2 or 6,) by window
    promised: float  # by how much the cost falls, were all of it linear


@dataclass(frozen=True)
class Shooting:
    """Roll-outs that numbers are learned from."""

    fit: Fit  # with numbers that are near
    known: Known
    misfits: Callable[[SimModel], Misfit]  # of a model
    free: NDArray[np.bool_]  # which numbers (p,) may move

    def learned(self, windows: Sequence[Swing]) -> Shot:
        """Return the numbers that fit the roll-outs of some windows best, from states at their starts that are near.

        Derivatives serve as long as a step gains half of what they promise, and are taken anew before the end. It
        comes where no number is off by more than a share of its standard deviation, which is what the residuals
        that are left make it: a step that promises g moves none by more than sqrt(g n / cost) of that.
        """
        here = self.at(numbers_of(self.fit), windows)
        slopes, fresh, anew = self.slopes(here), True, 1
        for _ in range(SOLVER.steps):
            step, gain = self.step(here, slopes), 0.0
            of_std = here.cost / sum(off.size for off in here.off)  # what a step of a standard deviation gains
            enough = DEBIAS.settled**2 * of_std
            if step.promised > enough:
                tried = self.along(here, step)
                gain, here = here.cost - tried.cost, tried
            if fresh and gain <= enough:
                break
            if gain > max(enough, step.promised / 2):
                fresh = fresh and step.promised <= of_std
                continue
            if anew >= SOLVER.refit_steps:
                break
            slopes, fresh, anew = self.slopes(here), True, anew + 1
        return here

    def misfit(self, numbers: Array) -> Misfit:
        """Return the misfit of the model with other numbers."""
        return self.misfits(sim_model(at_numbers(self.fit, numbers)))

    def at(self, numbers: Array, windows: Sequence[Swing]) -> Shot:
        """Return some numbers with what they cost."""
        misfit, away = self.misfit(numbers), numbers - self.known.numbers
        off = tuple(misfit(w)[1] for w in windows)
        cost = sum(float(x @ x) for x in off) + float(away @ self.known.information @ away)
        return Shot(numbers, tuple(windows), off, cost)

    def step(self, here: Shot, slopes: Slopes) -> Step:
        """Return the step that lowers the cost most, were the misfits as their derivatives say."""
        normal = self.known.information[np.ix_(self.free, self.free)].copy()
        gradient = (self.known.information @ (here.numbers - self.known.numbers))[self.free]
        back, promised = [], 0.0
        for off, state, by_numbers in zip(here.off, slopes.state, slopes.numbers, strict=True):
            both = np.column_stack([off, by_numbers])
            back.append(best_step(state, both))
            left = both + state @ back[-1]
            promised += float(off @ off - left[:, 0] @ left[:, 0])
            normal += left[:, 1:].T @ left[:, 1:]
            gradient = gradient + left[:, 1:].T @ left[:, 0]
        free = -np.linalg.solve(normal, gradient)
        numbers = np.zeros(here.numbers.size)
        numbers[self.free] = free
        states = tuple(own @ np.concatenate([[1.0], free]) for own in back)
        return Step(numbers, states, promised - float(free @ gradient))

    def slopes(self, here: Shot) -> Slopes:
        """Return the derivatives of every window's misfit, by differences."""
        priors = replace(self.fit.model, fixed=None).priors
        reach = ROLL_OUT.difference * np.concatenate([priors[n].std for n in self.fit.model.parameters.widths])
        there = {
            i: self.misfit(here.numbers + reach[i] * (np.arange(reach.size) == i)) for i in np.flatnonzero(self.free)
        }
        rig, misfit = sim_model(at_numbers(self.fit, here.numbers)).rig, self.misfit(here.numbers)
        states, numbers = [], []
        for window, off in zip(here.windows, here.off, strict=True):
            numbers.append(np.stack([(of(window)[1] - off) / reach[i] for i, of in there.items()], axis=1))
            states.append(slopes(rig, window, misfit))
        return Slopes(tuple(states), tuple(numbers))

    def along(self, here: Shot, step: Step) -> Shot:
        """Return the first of some lengths of a step that costs less, or where it was."""
        for length in SOLVER.lengths:
            numbers = here.numbers + length * step.numbers
            try:
                rig = sim_model(at_numbers(self.fit, numbers)).rig
                begun = [
                    replace(w, state=state_beside(rig, w.state, length * by))
                    for w, by in zip(here.windows, step.states, strict=True)
                ]
                tried = self.at(numbers, begun)
            except InputError:  # numbers that no rig can have
                continue
            if tried.cost < here.cost:
                return tried
        return here


def at_numbers(fit: Fit, numbers: Array) -> Fit:
    """Return a fit with other numbers (p,), its motion as it was."""
    columns = fit.model.parameters.columns
    values = {name: numbers[columns(name)] for name in fit.model.parameters.widths}
    return replace(fit, state=replace(fit.state, values=values))


def known_outside(fit: Fit, teaches: Callable[[Array], NDArray[np.bool_]], windows: Sequence[Swing]) -> Known:
    """Return what samples outside of some windows say of a fit's numbers, from the equations of its motion.

    Args:
        fit: of the whole recording.
        teaches: takes times (n,) in s of the recording's clock and returns which of them may teach (n,).
        windows: that are rolled out.
    """
    model, spans, parts = fit.model, [(w.start, w.end) for w in windows], []
    for rows in fit.rows:
        part, time = linearise(rows, model.tracks, model.parameters), rows.time + model.start
        parts.append(part.of(teaches(time) & ~covered(time, spans)) if is_data(rows) else part)
    _, step, _, information = half_step(Normal.of(model.tracks, model.parameters, parts))
    return Known(numbers_of(fit) + step, information)


__all__ = ["Known", "Shooting", "Shot", "at_numbers", "known_outside"]
