"""What a fit with an effect that has a life of its own is worth over one without it.

The evidence of a model integrates over every motion that its prior allows. A sensor on springs answers a motion T
times, T a function of frequency, so that its evidence has a term -sum ln |T| over all frequencies at which the prior
allows more motion than the noise shows: hundreds of nat for a resonance, of either sign, and about the prior alone. The
true motion has no power there. So the fits are compared by the likelihood of the samples less the freedoms that they
give to the fit, p = the trace of the hat matrix (the conditional Akaike criterion of Vaida and Blanchard 2005,
Biometrika 92:351), each at the noise level s that it leaves. Of n samples only n - p tell that level::

    (n - p) ln(s_before / s) - (cost - cost_before) - (p - p_before)

Where little is explained the levels' own scatter is more than that. What counts then, if it is less, is the whole cost,
priors and laws too, both fits at the later one's levels.
"""

from collections.abc import Mapping

import numpy as np

from imubench.diagnosis.noise.noise_levels import levels
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.motion_prior import TILT
from imubench.diagnosis.problem.residuals import Rows, is_data
from imubench.diagnosis.solve.gauss_newton import Step
from imubench.diagnosis.solve.levenberg_marquardt import at_noise_of
from imubench.diagnosis.solve.marginals import Marginals

Told = dict[str, tuple[int, float, float]]


def aic_gain(before: Fit, after: Fit) -> float:
    """Return the nat by which `after` predicts samples and free swings' equation better, each at its own noise."""
    return aic_gain_and_freedoms(before, after)[0]


def aic_gain_and_freedoms(before: Fit, after: Fit) -> tuple[float, float]:
    """Return the same, and how many more freedoms the data give to `after`."""
    ruler = at_noise_of(before, after)
    old, same, new = tally(before), tally(ruler), tally(after)
    spent = freedoms(new) - freedoms(same)
    nat = min(aic_gain_of(before.noise, old, after.noise, new), _cost(ruler) - _cost(after) - spent)
    return nat, freedoms(new) - freedoms(old)


def freedoms(told: Told) -> float:
    """Return the freedoms that all groups of data give."""
    return sum(p for _, p, _ in told.values())


def _cost(fit: Fit) -> float:
    return sum(r.cost for r in fit.rows if not r.name.startswith(TILT))


def aic_gain_of(noise_before: Mapping[str, float], old: Told, noise: Mapping[str, float], new: Told) -> float:
    """Return the likelihood less the freedoms of one fit over another: their noise levels and their tallies."""
    out = 0.0
    for name in sorted(old.keys() & new.keys()):
        (n, p, cost), (_, p_before, cost_before) = new[name], old[name]
        fell = np.log(noise_before[name] / noise[name]) if name in noise_before else 0.0
        out += float((n - p) * fell - (cost - cost_before) - (p - p_before))
    return out


def tally(fit: Fit) -> Told:
    """Return how many numbers every group of data has, the freedoms that they give, and what they cost."""
    _, leverage = levels(fit)
    return {r.name: (r.residual.value.size, float(leverage[r.name].sum()), r.cost) for r in fit.rows if is_data(r)}


def linear_tally(model: Model, rows: list[Rows]) -> Told:
    """Return the same after one linear step from where the rows were taken, as far as they are linear.

    A whole step in what is not linear (play turns one sensor against the other) would end anywhere.
    """
    step = Step.of(model, rows)
    motion, spread = step.splines.reshape(-1, model.tracks.width, 1), Marginals.of(step.solution, model.tracks.width)
    data = [(r, part) for r, part in zip(rows, step.linear, strict=True) if is_data(r)]
    out = {}
    for (r, part), leverage in zip(data, spread.leverages([part for _, part in data]), strict=True):
        left = part.residual + part.along(motion)[:, :, 0] + part.border @ step.values
        out[r.name] = (left.size, float(leverage.sum()), 0.5 * float(np.sum(left**2)))
    return out


__all__ = ["aic_gain", "aic_gain_and_freedoms", "aic_gain_of", "linear_tally", "tally"]
