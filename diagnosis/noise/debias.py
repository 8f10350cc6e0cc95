"""Why the best state is not the best parameter, and what is done about it.

The fit moves the splines z and an effect's parameters t to where the cost is least. Noise n in the measurements
moves the splines by dz = -H^-1 J' n as well, and a law's rows L(t) z weigh what they do there: an undamped spring
follows noise that a damped one would not. At the true t the cost therefore has a slope, not zero but

    E[(L dz)' (dL/dt) dz],

which is zero only where the motion is free to go anywhere; its prior and the law's narrow resonance make it large.
Equating the slope of the cost with it, instead of with zero, takes the bias away. The expectation is a mean over
draws of the noise; each is one more right-hand side of a system that is factored anyhow.

What noise makes a law do also looks like information: of I = (dL/dt z)' (dL/dt z), once all the rest has followed, a
part N = E[(dL/dt dz)' (dL/dt dz)] says nothing about t. The slope less its expectation changes with t by I - N alone,
while its own variance is I: a step is (I - N)^-1 times the slope, and t's covariance (I - N)^-1 I (I - N)^-1.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np

from imubench.arrays import Array
from imubench.chain_rule import chained
from imubench.diagnosis.config.noise import DEBIAS
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, Prior, State
from imubench.diagnosis.problem.process_factors import laws_on_segment, scenes
from imubench.diagnosis.problem.residuals import Rows
from imubench.diagnosis.solve.block_tridiagonal import Factor
from imubench.diagnosis.solve.bordered import Solution
from imubench.diagnosis.solve.linearize import Held, Linear
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.jets import CONSTANT, Blocks, Jet, times

Residuals = dict[str, Array]
"""Whitened residuals (n, m, draws) under noise, by group."""


@dataclass(frozen=True)
class NoiseOnLaws:
    """What the measurements' noise does to laws, for k of their numbers."""

    pull: Array  # (k,) the slope of the cost to be expected
    noise: Array  # (k, k) N
    whole: Array  # (k, k) I

    def grown(self, most: float = DEBIAS.most_from_noise) -> Array:
        """Return I (I - N)^-1 (k, k), no share of N larger than `most`."""
        values, vectors = np.linalg.eigh(self.whole)
        root = (vectors * np.sqrt(np.maximum(values, ALGEBRA.half_digits * values[-1]))) @ vectors.T
        back = np.linalg.inv(root)
        shares, axes = np.linalg.eigh(back @ self.noise @ back)
        return np.asarray(root @ (axes / (1 - np.clip(shares, 0.0, most))) @ axes.T @ back)


def noise_pull(
    fit: Fit, normal: Normal, solution: Solution, parts: list[Linear], every: bool = False, share: float = 1.0
) -> dict[str, Prior]:
    """Return the pull on a law's logarithmic parameters, or on all, as a place and how weakly it is held there.

    `normal`, `solution` and `parts` are those of the fit's rows; `share`: of the whole step, how much is taken.
    """
    logs = {name: log for _, name, log in law_parameters(fit) if log or every}
    names = list(logs)
    if not names:
        return {}
    now, told = fit.state.values, fit.model.tilts or {}
    driven = driven_by_noise(fit, solution, parts, names)
    places = fit.model.parameters.places(names)
    _, slope = solution.reduced(normal.gradient, normal.corner_gradient, places)
    stiff = [np.ones(len(now[n])) / told[n].std ** 2 if n in told else np.zeros(len(now[n])) for n in names]
    driven = replace(driven, whole=driven.whole - np.diag(np.concatenate(stiff)))  # a pull is no information
    pulled = [(told[n].start - now[n]) / told[n].std ** 2 if n in told else np.zeros(len(now[n])) for n in names]
    slope = slope + np.concatenate(pulled)  # the cost's own, without the pull
    aim = slope + share * driven.grown(DEBIAS.most_of_step) @ (driven.pull - slope)
    out = {}
    for name, pull in zip(names, np.split(aim, np.cumsum([len(p) for p in pulled])[:-1]), strict=True):
        far = DEBIAS.most_pull * (1.0 if logs[name] else fit.model.priors[name].std)
        std = np.sqrt(far / np.maximum(np.abs(pull), 1e-9))
        out[name] = Prior(now[name] + far * np.sign(pull), std)
    return out


def widened_by_noise(fit: Fit, solution: Solution, parts: list[Linear]) -> dict[str, Array]:
    """Return by what the standard deviations of the laws' numbers are larger than the fit's own information says."""
    names = [name for _, name, _ in law_parameters(fit)]
    if not names:
        return {}
    driven = driven_by_noise(fit, solution, parts, names)
    grown, covariance = driven.grown(), np.linalg.inv(driven.whole)
    ratio = np.sqrt(np.diag(grown.T @ covariance @ grown) / np.diag(covariance))
    widths = [len(fit.state.values[n]) for n in names]
    return dict(zip(names, np.split(np.maximum(ratio, 1.0), np.cumsum(widths)[:-1]), strict=True))


def law_parameters(fit: Fit) -> list[tuple[Hypothesis, str, bool]]:
    """Return every parameter of a law with a state: whose, its name in the fit, and whether it is a logarithm."""
    laws = [h for h in fit.model.hypotheses if h.effect.lawful and any(p.log for p in h.effect.parameters)]
    free = fit.model.fixed or {}
    return [(h, h.key(p.name), p.log) for h in laws for p in h.effect.parameters if h.key(p.name) not in free]


def driven_by_noise(fit: Fit, solution: Solution, parts: list[Linear], names: Sequence[str]) -> NoiseOnLaws:
    """Return what noise does to laws, for all numbers of the named parameters."""
    moved, drawn = noise_draws(fit, solution.factor, parts)
    pull, slopes = [], []
    for left, slope in _slopes(fit, names, moved, drawn):
        pull.append(float(sum(np.sum(left[group] * column) for group, column in slope.items())) / DEBIAS.draws)
        slopes.append(slope)
    own = np.array([[sum(np.sum(a[g] * b[g]) for g in a.keys() & b.keys()) for b in slopes] for a in slopes])
    groups = {r.name: part for r, part in zip(fit.rows, parts, strict=True)}
    noise = _seen_beside(fit, solution, groups, slopes, own) / DEBIAS.draws
    places = fit.model.parameters.places(list(names))
    whole = np.linalg.inv(np.linalg.inv(solution.schur)[np.ix_(places, places)])
    return NoiseOnLaws(np.array(pull), noise, (whole + whole.T) / 2)


def _seen_beside(
    fit: Fit, solution: Solution, groups: Mapping[str, Linear], slopes: Sequence[Residuals], own: Array
) -> Array:
    """Return the products (k, k) `own` of k numbers' slopes once all the rest has followed, summed over the draws.

    Some draws at a time: the columns of all, 24 numbers of two springs, would be most of what a long fit holds.
    """
    blocks, width, count = len(solution.factor.lower), fit.model.tracks.width, len(slopes)
    beside = fit.model.tracks.knots.count <= ALGEBRA.knots_beside
    used = {group for slope in slopes for group in slope}
    jacobians = {group: Held.of(groups[group]) if beside else groups[group] for group in sorted(used)}
    at_once = max(2 * ALGEBRA.columns // max(count, 1), 1)
    for some in (slice(i, min(i + at_once, DEBIAS.draws)) for i in range(0, DEBIAS.draws, at_once)):
        draws = some.stop - some.start
        columns, across = np.zeros((blocks, ALGEBRA.knots_per_block * width, count, draws)), []
        for i, slope in enumerate(slopes):
            cross = np.zeros((blocks * ALGEBRA.knots_per_block, width, draws))
            for group, column in slope.items():
                jacobians[group].scatter(column[:, :, some], cross)
            columns[:, :, i] = cross.reshape(blocks, -1, draws)
            seen = (np.tensordot(groups[g].border, c[:, :, some], axes=((0, 1), (0, 1))) for g, c in slope.items())
            across.append(sum(seen))
        own = solution.complements(columns, np.stack(across, axis=1), own)
    return own


def noise_draws(fit: Fit, factor: Factor, parts: list[Linear]) -> tuple[Array, Residuals]:
    """Return what draws of the measurements' noise do to the splines (knots, width, draws), and the draws by group."""
    rng = np.random.default_rng(STATISTICS.seed)
    width = fit.model.tracks.width
    pull = np.zeros((len(factor.lower) * ALGEBRA.knots_per_block, width, DEBIAS.draws))
    drawn = {}
    for rows, part in zip(fit.rows, parts, strict=True):
        if rows.counts:
            drawn[rows.name] = rng.standard_normal((*part.residual.shape, DEBIAS.draws))
            part.scatter(drawn[rows.name], pull)
    moved = factor.solve(-pull.reshape(len(factor.lower), -1, DEBIAS.draws))
    return np.asarray(moved.reshape(-1, width, DEBIAS.draws)), drawn


@dataclass(frozen=True)
class MovedByNoise:
    """Splines that noise has moved, their values at times that were asked for kept: every number asks for the same."""

    fit: Fit
    moved: Array  # (knots or more, width, draws)
    known: dict[tuple[bytes, str, int], Array] = field(default_factory=dict)

    def values(self, time: Array, name: str, order: int) -> Array:
        """Return the `order`-th derivative (n, k, draws) of a spline's moves at times (n,); samples side by side."""
        key = (time.tobytes(), name, order)
        if key not in self.known:
            tracks = self.fit.model.tracks
            own = self.moved[: tracks.knots.count, tracks.columns(name)]
            flat = tracks.knots.values(time, order, own.reshape(len(own), -1))
            self.known[key] = flat.T.reshape(*own.shape[1:], len(time)).transpose(2, 0, 1)
        return self.known[key]

    def change(self, rows: Rows, blocks: Blocks) -> Array:
        """Return what the moves do (n, m, draws) through some derivatives of rows, over their standard deviation."""
        out = np.zeros((self.moved.shape[2], rows.residual.value.shape[1], len(rows.time))).transpose(2, 1, 0)
        for (name, order), block in blocks.items():
            if order != CONSTANT:
                out += times(block, self.values(rows.time, name, order))
        return out / (np.broadcast_to(rows.std, rows.residual.value.shape) * self.level(rows.name))[:, :, None]

    def level(self, name: str) -> float:
        """Return the noise level of a group of rows."""
        return self.fit.noise.get(name, 1.0) * self.fit.loose


def _slopes(fit: Fit, names: Sequence[str], moved: Array, drawn: Residuals) -> Iterator[tuple[Residuals, Residuals]]:
    """Yield residuals under noise, and how they change with a number, for all numbers of the parameters.

    A logarithm (of a stiffness, a damping, a cutoff) is in the law alone, and what the law asks of the rig stays;
    another number (a lever arm) may be in what the law's sensor reads as well. Derivatives that a number leaves as they
    are, and rows of which it leaves all, need no product.
    """
    model, state, noise = fit.model, fit.state, MovedByNoise(fit, moved)
    for h, own in groupby(law_parameters(fit), key=lambda one: one[0]):
        ((_, scene),) = scenes(model, state, h)
        asked = [(name, log) for _, name, log in own if name in names]
        law = list(laws_on_segment(model, state, h, scene))
        read = [] if all(log for _, log in asked) else list(model.measured(state, (h.at,)))
        left = {r.name: noise.change(r, chained(r.residual, scene.segment).blocks) for r in law}
        left |= {r.name: drawn[r.name] + noise.change(r, r.residual.blocks) for r in read}
        for name, log in asked:
            for i, std in enumerate(model.priors[name].std):
                value = state.values[name].copy()
                value[i] += ALGEBRA.difference * std
                there = State(state.coefficients, state.values | {name: value})
                ((_, seen),) = [(h, scene)] if log else scenes(model, there, h)
                slope = {}
                for before, after in zip(law, laws_on_segment(model, there, h, seen), strict=True):
                    if log:
                        change = chained(changed(before.residual, after.residual), scene.segment)
                    else:  # a number of a joint's may move the segment as well
                        ends = ((before, scene), (after, seen))
                        change = changed(*(chained(rows.residual, at.segment) for rows, at in ends))
                    slope[before.name] = noise.change(before, change.blocks)
                for before, after in () if log else zip(read, model.measured(there, (h.at,)), strict=True):
                    if blocks := changed(before.residual, after.residual).blocks:
                        slope[before.name] = noise.change(before, blocks)
                yield left, {group: column / (ALGEBRA.difference * std) for group, column in slope.items()}


def changed(before: Jet, after: Jet) -> Jet:
    """Return the change of a residual's derivatives, without those that have not changed."""
    blocks = {}
    for key in before.blocks | after.blocks:
        one, other = before.blocks.get(key), after.blocks.get(key)
        change = other if one is None else -one if other is None else other - one
        if change is not None and np.any(change):
            blocks[key] = change
    return Jet(before.value, blocks)
