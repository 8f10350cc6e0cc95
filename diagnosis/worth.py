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

import numpy as np

from imubench.diagnosis.fit import Fit, solve
from imubench.diagnosis.noise import levels
from imubench.diagnosis.priors import TILT
from imubench.diagnosis.swings import GROUP

Told = dict[str, tuple[int, float, float]]


def worth(before: Fit, after: Fit) -> float:
    """Return the nat by which `after` predicts samples and free swings' equation better, each at its own noise."""
    ruler = solve(before.model, before.state, {n: after.noise[n] for n in before.noise}, before.anchor, steps=3)
    old, same, new = tallied(before), tallied(ruler), tallied(after)
    freedoms = sum(p for _, p, _ in new.values()) - sum(p for _, p, _ in same.values())
    return min(won(before, old, after, new), _cost(ruler) - _cost(after) - freedoms)


def _cost(fit: Fit) -> float:
    return sum(r.cost for r in fit.rows if not r.name.startswith(TILT))


def won(before: Fit, old: Told, after: Fit, new: Told) -> float:
    """Return the likelihood less the freedoms that `after` has over `before`, by what `tallied` says of them."""
    out = 0.0
    for name in sorted(old.keys() & new.keys()):
        (n, p, cost), (_, p_before, cost_before) = new[name], old[name]
        fell = np.log(before.noise[name] / after.noise[name]) if name in before.noise else 0.0
        out += float((n - p) * fell - (cost - cost_before) - (p - p_before))
    return out


def tallied(fit: Fit) -> Told:
    """Return how many numbers every group of data has, the freedoms that they give, and what they cost."""
    _, leverage = levels(fit)
    data = [r for r in fit.rows if r.counts or r.name == GROUP]
    return {r.name: (r.residual.value.size, float(leverage[r.name].sum()), r.cost) for r in data}


__all__ = ["tallied", "won", "worth"]
