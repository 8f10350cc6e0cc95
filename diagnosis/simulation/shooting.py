"""Numbers that roll-outs show: multiple shooting over free swings.

The equation of motion, asked once between two knots, knows a mount's rotation to a milliradian: a spline motion that is
free to follow every sample takes up what a wrong mount does to it. A roll-out has no such freedom: what a wrong number
does to it grows over the window, and at 10 rad/s a milliradian is ten times a gyroscope's noise. So in windows that are
rolled out numbers p come from the roll-outs themselves, with a state s_w at the start of each. They minimise

    sum over windows w of |simulated(p, s_w) - measured|^2 / noise^2  +  (p - p0)' K (p - p0)

K and p0 are what priors and all other samples that may teach say: the equations of the motion fit without the rows in
the windows. With r = simulated - measured over the noise, S and A its derivatives by s_w and p, and P = 1 - S S^+ what
no state takes up, a step of Gauss and Newton obeys  (K + sum A' P A) dp = -(K (p - p0) + sum A' P r).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA, SOLVER
from imubench.diagnosis.criteria.cross_validation import half_step
from imubench.diagnosis.evidence import Swing
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import is_data
from imubench.diagnosis.simulation.learned import numbers_of
from imubench.diagnosis.simulation.rollout import Misfit, best_step, refined, slopes, state_beside
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
    """Numbers (p,), and the windows with the states at their starts that fit best with them."""

    numbers: Array
    windows: tuple[Swing, ...]
    cost: float  # squared residuals over the noise, and what is known otherwise


@dataclass(frozen=True)
class Shooting:
    """Roll-outs that numbers are learned from."""

    fit: Fit  # with numbers that are near
    known: Known
    misfits: Callable[[SimModel], Misfit]  # of a model
    free: NDArray[np.bool_]  # which numbers (p,) may move

    def learned(self, windows: Sequence[Swing]) -> Shot:
        """Return the numbers that fit the roll-outs of some windows best, from states at their starts that are near."""
        best = self.at(numbers_of(self.fit), windows)
        for _ in range(SOLVER.few_steps):
            step, promised, follow = self.step(best)
            if promised < SOLVER.least_gain * best.cost:
                break
            tried = self.along(best, step, follow)
            gain = best.cost - tried.cost
            if gain > 0:
                best = tried
            if gain < SOLVER.least_gain * best.cost:
                break
        return best

    def misfit(self, numbers: Array) -> Misfit:
        """Return the misfit of the model with other numbers."""
        return self.misfits(sim_model(at_numbers(self.fit, numbers)))

    def at(self, numbers: Array, windows: Sequence[Swing]) -> Shot:
        """Return some numbers with what they cost."""
        misfit, away = self.misfit(numbers), numbers - self.known.numbers
        cost = sum(float(np.sum(misfit(w)[1] ** 2)) for w in windows)
        return Shot(numbers, tuple(windows), cost + float(away @ self.known.information @ away))

    def step(self, here: Shot) -> tuple[Array, float, list[Array]]:
        """Return the step of the numbers (p,), what it promises, and by window the states' own step and slope."""
        rig, misfit = sim_model(at_numbers(self.fit, here.numbers)).rig, self.misfit(here.numbers)
        normal = self.known.information[np.ix_(self.free, self.free)].copy()
        gradient = (self.known.information @ (here.numbers - self.known.numbers))[self.free]
        follow = []
        for window, by_numbers in zip(here.windows, self.slopes(here), strict=True):
            both = np.column_stack([misfit(window)[1], by_numbers])
            state = slopes(rig, window, misfit)
            back = np.column_stack([best_step(state, column) for column in both.T])
            left = both + state @ back
            normal += left[:, 1:].T @ left[:, 1:]
            gradient = gradient + left[:, 1:].T @ left[:, 0]
            follow.append(back)
        free = -np.linalg.solve(normal, gradient)
        step = np.zeros(here.numbers.size)
        step[self.free] = free
        return step, float(-free @ gradient), follow

    def slopes(self, here: Shot) -> list[Array]:
        """Return the derivatives (n, p) of every window's misfit by the numbers that are free, by differences."""
        priors = replace(self.fit.model, fixed=None).priors
        reach = ALGEBRA.difference * np.concatenate([priors[n].std for n in self.fit.model.parameters.widths])
        there = {
            i: self.misfit(here.numbers + reach[i] * (np.arange(reach.size) == i)) for i in np.flatnonzero(self.free)
        }
        misfit, out = self.misfit(here.numbers), []
        for window in here.windows:
            off = misfit(window)[1]
            out.append(np.stack([(of(window)[1] - off) / reach[i] for i, of in there.items()], axis=1))
        return out

    def along(self, here: Shot, step: Array, follow: Sequence[Array]) -> Shot:
        """Return the first of some lengths of a step that costs less, or where it was."""
        for length in SOLVER.lengths:
            numbers = here.numbers + length * step
            ahead = [back @ np.concatenate([[1.0], length * step[self.free]]) for back in follow]
            try:
                rig, misfit = sim_model(at_numbers(self.fit, numbers)).rig, self.misfit(numbers)
                begun = [
                    refined(rig, replace(w, state=state_beside(rig, w.state, by)), misfit, w.end - w.start)
                    for w, by in zip(here.windows, ahead, strict=True)
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
