"""Further columns beside a fit: what they would explain once motion, geometry and effects have followed."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.bordered import Solution
from imubench.diagnosis.solve.gauss_newton import Step
from imubench.diagnosis.solve.linearize import Held, Linear
from imubench.diagnosis.solve.threads import one_thread


@dataclass(frozen=True)
class Base:
    """A fit's normal equations, factored once for all columns."""

    fit: Fit
    parts: dict[str, Linear]
    step: Step  # from the fit to the best state of the quadratic model, and its equations
    held: dict[str, Held] = field(default_factory=dict)  # Jacobians that were asked for, where the fit is not too long

    @classmethod
    @one_thread
    def of(cls, fit: Fit) -> "Base":
        """Return the factored equations at the fit's state."""
        step = Step.of(fit.model, fit.rows)
        parts = {rows.name: part for rows, part in zip(fit.rows, step.linear, strict=True)}
        return cls(fit, parts, step)

    @property
    def solution(self) -> Solution:
        """The factored equations."""
        return self.step.solution

    @property
    def at_once(self) -> int:
        """How many parameters' columns may be held together: as many numbers each as a fit has coefficients."""
        tracks = self.fit.model.tracks
        return min(ALGEBRA.columns, ADMISSION.numbers_at_once // max(tracks.knots.count * tracks.width, 1))

    def std_of(self, name: str, std: Array) -> Array:
        """Return the standard deviation that the fit gives to rows of a group."""
        return std * self.fit.noise[name] * self.fit.loose

    def _jacobian(self, name: str) -> Held | Linear:
        """Return the splines' Jacobian of a group of rows, to be multiplied with columns."""
        if self.fit.model.tracks.knots.count > ALGEBRA.knots_beside:
            return self.parts[name]
        if name not in self.held:
            self.held[name] = Held.of(self.parts[name])
        return self.held[name]

    def reduced(self, columns: Iterable[tuple[str, Array]], count: int) -> tuple[Array, Array]:
        """Return information (k, k) and gradient (k,) of `count` columns, whitened (n, m, k), by group of rows."""
        blocks, p = len(self.solution.factor.lower), self.fit.model.parameters.count
        cross = np.zeros((blocks * ALGEBRA.knots_per_block, self.fit.model.tracks.width, count))
        across, corner, gradient = np.zeros((p, count)), np.zeros((count, count)), np.zeros(count)
        for name, some in columns:
            part, flat = self.parts[name], some.reshape(-1, count)
            self._jacobian(name).scatter(some, cross)
            across += part.border.reshape(len(flat), p).T @ flat
            corner += flat.T @ flat
            gradient += flat.T @ part.residual.reshape(-1)
        cross, step = cross.reshape(blocks, -1, count), self.step
        # columns like others would take what these left
        gradient += np.tensordot(step.splines, cross, axes=2) + step.values @ across
        return self.solution.complement(cross, across, corner), gradient


@dataclass(frozen=True)
class Promise:
    """What the quadratic model of the cost promises of parameters under a prior."""

    step: Array  # (k,) from the prior's centre
    gain: float  # nat, of the log likelihood and prior
    price: float  # nat, of the freedom
    bound: Array  # (k,) standard deviations

    @property
    def evidence(self) -> float:
        """The gain less the price."""
        return self.gain - self.price


def promise(information: Array, gradient: Array, prior: Array) -> Promise:
    """Return what parameters (k,) promise, `prior` their standard deviations; worked in units of these."""
    matrix = information * np.outer(prior, prior) + np.eye(len(prior))
    pull = gradient * prior
    values, vectors = np.linalg.eigh(matrix)
    values = np.maximum(values, 1.0)  # information below 0 is rounding
    step = -vectors @ ((vectors.T @ pull) / values)
    price = 0.5 * float(np.sum(np.log(values)))
    bound = prior * np.sqrt(np.sum(vectors**2 / values, axis=1))
    return Promise(step * prior, -0.5 * float(step @ pull), price, bound)


def together(candidates: Iterable[Hypothesis], most: int) -> Iterator[list[Hypothesis]]:
    """Yield effects so many at a time that they have `most` numbers, or one that has more."""
    some: list[Hypothesis] = []
    count = 0
    for h in candidates:
        if some and count + h.effect.numbers > most:
            yield some
            some, count = [], 0
        some.append(h)
        count += h.effect.numbers
    if some:
        yield some
