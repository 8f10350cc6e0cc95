"""What a fit with an effect that has a life of its own is worth over one without it.

The evidence of a model integrates over every motion that its prior allows. A sensor on springs answers a motion T
times, T a function of frequency, so that its evidence has a term -sum ln |T| over all frequencies at which the prior
allows more motion than the noise shows: hundreds of nat for a resonance, of either sign, and about the prior alone. The
true motion has no power there. So the fits are compared as predictions are: at equal noise, by what the cost falls by
less the freedoms that the samples give to the fit, the trace of the hat matrix (Akaike's criterion, for
splines held by priors).
"""

from imubench.diagnosis.fit import Fit, solve
from imubench.diagnosis.noise import levels
from imubench.diagnosis.priors import TILT


def worth(before: Fit, after: Fit) -> float:
    """Return the nat by which `after` explains the samples better than `before` does, its freedoms taken off."""
    ruler = solve(before.model, before.state, {n: after.noise[n] for n in before.noise}, before.anchor, steps=3)
    return _cost(ruler) - _cost(after) - (_freedoms(after) - _freedoms(ruler))


def _cost(fit: Fit) -> float:
    return sum(r.cost for r in fit.rows if not r.name.startswith(TILT))


def _freedoms(fit: Fit) -> float:
    _, leverage = levels(fit)
    return sum(float(leverage[r.name].sum()) for r in fit.measured)


__all__ = ["worth"]
