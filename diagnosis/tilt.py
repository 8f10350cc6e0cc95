"""Why the best state is not the best parameter, and what is done about it.

The fit moves the splines z and an effect's parameters t to where the cost is least. Noise n in the measurements
moves the splines by dz = -H^-1 J' n as well, and a law's rows L(t) z weigh what they do there: an undamped spring
follows noise that a damped one would not. At the true t the cost therefore has a slope, not zero but

    E[(L dz)' (dL/dt) dz],

which is zero only where the motion is free to go anywhere; its prior and the law's narrow resonance make it large.
Equating the slope of the cost with it, instead of with zero, takes the bias away. The expectation is a mean over
draws of the noise; each is one more right-hand side of a system that is factored anyhow.
"""

from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.blocks import Factor
from imubench.diagnosis.equations import state_rows
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.model import Hypothesis, Prior, State
from imubench.diagnosis.rows import KNOTS_PER_BLOCK, Linear, linearise

DRAWS = 16
SEED = 4401  # of the draws, so that a fit repeats itself
DELTA = 1e-3  # of a parameter's logarithm: the step of the difference
FURTHEST = 0.5  # of the same: how far one pull may lead


def tilts(fit: Fit, factor: Factor, parts: list[Linear]) -> dict[str, Prior]:
    """Return the pull on every logarithmic parameter of a law, as a place and how weakly it is held there.

    `factor` and `parts` are those of the fit's rows.
    """
    laws = [h for h in fit.model.hypotheses if h.effect.lawful and any(p.log for p in h.effect.parameters)]
    if not laws:
        return {}
    moved = noisy(fit, factor, parts)
    out = {}
    for h in laws:
        left = _residual(fit, fit.state, h, moved)
        for p in h.effect.parameters:
            if p.log:
                name = h.key(p.name)
                slope = np.array([float(np.sum(left * _slope(fit, h, name, i, moved))) for i in range(p.width)]) / DRAWS
                reach = FURTHEST * np.sign(slope)
                std = np.sqrt(FURTHEST / np.maximum(np.abs(slope), 1e-9))
                out[name] = Prior(fit.state.values[name] + reach, std)
    return out


def noisy(fit: Fit, factor: Factor, parts: list[Linear]) -> Array:
    """Return what draws of the measurements' noise do to the splines (knots, width, DRAWS)."""
    rng = np.random.default_rng(SEED)
    width = fit.model.tracks.width
    pull = np.zeros((len(factor.lower) * KNOTS_PER_BLOCK, width, DRAWS))
    for rows, part in zip(fit.rows, parts, strict=True):
        if rows.counts:
            part.scatter(rng.standard_normal((*part.residual.shape, DRAWS)), pull)
    moved = factor.solve(-pull.reshape(len(factor.lower), -1, DRAWS))
    return np.asarray(moved.reshape(-1, width, DRAWS))


def _slope(fit: Fit, h: Hypothesis, name: str, i: int, moved: Array) -> Array:
    """Return how the law's residuals under noise change with one number of a parameter."""
    ends = []
    for way in (1, -1):
        value = fit.state.values[name].copy()
        value[i] += way * DELTA
        ends.append(_residual(fit, State(fit.state.coefficients, fit.state.values | {name: value}), h, moved))
    return np.asarray((ends[0] - ends[1]) / (2 * DELTA))


def _residual(fit: Fit, state: State, h: Hypothesis, moved: Array) -> Array:
    """Return the whitened residuals (n, m, DRAWS) of h's law where noise has moved the splines."""
    out = []
    for rows in state_rows(fit.model, state, h):
        whitened = replace(rows, std=rows.std * fit.noise.get(rows.name, 1.0) * fit.loose)
        part = linearise(whitened, fit.model.tracks, fit.model.parameters)
        out.append(part.along(moved))
    return np.concatenate(out, axis=1)
