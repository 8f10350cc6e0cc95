"""Standard deviations of the fitted parameters where the noise is not white.

A parameter's error is what the noise e of every sample adds, sum_t a(t) e(t), with the influence a that the fit gives
each sample. Its variance is the sum of |A(f)|^2 S(f): A the influence's spectrum, S the noise power, 1 for
white noise of the fitted level. What the fit leaves shows S, once divided by what it would leave of white noise: the
motion follows slow noise more than quick noise, and that share is found by handing white noise to the same linear fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.noise import COLOUR
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.noise.debias import widened_by_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.motion_prior import TILT
from imubench.diagnosis.problem.residuals import Rows, is_data
from imubench.diagnosis.remembered import kept_with
from imubench.diagnosis.solve.bordered import Solution
from imubench.diagnosis.solve.gauss_newton import factored
from imubench.diagnosis.solve.linearize import Linear
from imubench.diagnosis.solve.marginals import Marginals, covariance_of
from imubench.diagnosis.solve.threads import one_thread


@dataclass(frozen=True)
class Spectra:
    """Noise power of one group of rows over white noise's of the fitted level, in bands that double in width."""

    edges: Array  # (bands + 1,) bins of the transform of all samples
    power: Array  # (bands,)
    seen: Array  # (bands,) share of white noise's power that the fit leaves

    def at(self, bins: int) -> Array:
        """Return the power (bins,) at every bin; a constant counts to the slowest band."""
        band = np.searchsorted(self.edges, np.arange(bins), side="right") - 1
        return np.asarray(self.power[np.clip(band, 0, len(self.power) - 1)])


@one_thread
def parameter_std(fit: Fit) -> dict[str, Array]:
    """Return every parameter's standard deviations, colour of the residuals and noise in a law's states counted in."""
    fit, solution, parts = _solved(fit)
    measured, doubts = _measured(fit, parts), widened_by_noise(fit, solution, parts)
    spread = replace(Marginals.of(solution, fit.model.tracks.width), shared=covariance_of(fit.model, solution.schur))
    variance = np.diag(spread.shared).copy()
    for (r, part), white in zip(measured, white_residuals(solution, measured, fit.model.tracks.width), strict=True):
        found = spectra(r.whitened, white)
        a = influence(spread, part)
        power = np.sum(np.abs(np.fft.rfft(a, axis=0)) ** 2, axis=1) / len(a)  # (bins, p)
        power[1 : (len(a) + 1) // 2] *= 2
        variance += (found.at(len(power)) - 1) @ power
    std = np.sqrt(np.maximum(variance, COLOUR.least_spectrum * np.diag(spread.shared)))
    return {name: std[fit.model.parameters.columns(name)] * doubts.get(name, 1.0) for name in fit.model.priors}


def off_none(fit: Fit, key: str) -> float:
    """Return by how many standard deviations a number is off none whose logarithm is fitted: a filter's delay, say."""
    return 1 / float(np.max(parameter_std(fit)[key]))


@kept_with
@one_thread
def noise_spectra(fit: Fit) -> dict[str, Spectra]:
    """Return the colour of every group of measurements, and of the equation of motion in free swings.

    Not to be written to: every effect's equals ask for it.
    """
    bare, solution, parts = _solved(fit)
    measured = [(r, part) for r, part in zip(bare.rows, parts, strict=True) if is_data(r)]
    white = white_residuals(solution, measured, bare.model.tracks.width)
    return {r.name: spectra(r.whitened, w) for (r, _), w in zip(measured, white, strict=True)}


def _solved(fit: Fit) -> tuple[Fit, Solution, list[Linear]]:
    """Return the fit without pulls on its parameters, factored, and the Jacobians of its rows."""
    fit = replace(fit, rows=[r for r in fit.rows if not r.name.startswith(TILT)])
    _, solution, parts = factored(fit.model, fit.rows)
    return fit, solution, parts


def _measured(fit: Fit, parts: list[Linear]) -> list[tuple[Rows, Linear]]:
    return [(r, part) for r, part in zip(fit.rows, parts, strict=True) if r.counts]


def influence(spread: Marginals, part: Linear) -> Array:
    """Return how far a whitened residual of 1 moves the parameters (n, m, p)."""
    return np.asarray((part.border - part.along(spread.reach)) @ spread.shared)


def white_residuals(solution: Solution, measured: Sequence[tuple[Rows, Linear]], width: int) -> list[Array]:
    """Return what the linear fit leaves of draws of white noise, (n, m, draws) for every group."""
    rng = np.random.default_rng(STATISTICS.seed)
    noise = [rng.standard_normal((*part.residual.shape, COLOUR.draws)) for _, part in measured]
    blocks, b, p = solution.border.shape
    pull = np.zeros((blocks * ALGEBRA.knots_per_block, width, COLOUR.draws))
    shared = np.zeros((p, COLOUR.draws))
    for (_, part), e in zip(measured, noise, strict=True):
        part.scatter(e, pull)
        shared += np.einsum("nmp,nmd->pd", part.border, e)
    x, values = solution.solve(pull.reshape(blocks, b, COLOUR.draws), shared)
    knots = x.reshape(-1, width, COLOUR.draws)
    return [e - part.border @ values - part.along(knots) for (_, part), e in zip(measured, noise, strict=True)]


def spectra(left: Array, white: Array) -> Spectra:
    """Return the noise power that residuals (n, m) show, beside residuals of white noise (n, m, draws)."""
    bins = len(left) // 2 + 1
    edges = [1]
    while 3 * edges[-1] < bins:
        edges.append(2 * edges[-1] + 2)
    edges.append(bins)
    power = np.sum(np.abs(np.fft.rfft(left, axis=0)) ** 2, axis=1)
    expected = np.mean(np.sum(np.abs(np.fft.rfft(white, axis=0)) ** 2, axis=1), axis=1)
    whole = left.shape[1] * len(left)  # power of white noise in one bin
    seen = np.array([np.mean(expected[low:high]) for low, high in pairwise(edges)]) / whole
    found = np.array([np.mean(power[low:high]) for low, high in pairwise(edges)]) / whole
    ratio = np.where(seen > COLOUR.least_left, found / np.maximum(seen, COLOUR.least_left), 1.0)
    return Spectra(np.array(edges, dtype=float), np.maximum(ratio, COLOUR.least_spectrum), seen)


__all__ = ["Spectra", "influence", "noise_spectra", "off_none", "parameter_std", "spectra", "white_residuals"]
