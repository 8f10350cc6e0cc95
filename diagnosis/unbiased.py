"""Springs whose numbers lean on no noise: as few knots as there may be, and every number pulled.

While names are sought, only stiffnesses and dampings are pulled (diagnosis/tilt.py). A lever arm leans as well: what
noise turns a rocking sensor by moves its sensing point, which explains noise of its accelerometer (arms of 5 to 9 cm
that were below 2, by up to 7 standard deviations). Here every number of a law is pulled until none moves any more.
"""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.coarser import coarsest
from imubench.diagnosis.fit import AGAIN, Fit, solve
from imubench.diagnosis.noise import FINE
from imubench.diagnosis.system import factored
from imubench.diagnosis.threads import one_thread
from imubench.diagnosis.tilt import lawful, tilts

ROUNDS = 10  # of pulls at most
STILL = 0.03  # of its prior's standard deviation: a number that moves less has settled


def unbiased(fit: Fit) -> Fit:
    """Return the fit with its laws' numbers pulled off what noise makes of them."""
    return settled(coarsest(fit)) if lawful(fit) else fit


@one_thread
def settled(fit: Fit) -> Fit:
    """Return the fit at the noise levels that it has, every number of its laws pulled until all stay."""
    for _ in range(ROUNDS):
        normal, solution, parts = factored(fit.model, fit.rows)
        model = replace(fit.model, tilts=tilts(fit, normal, solution, parts, every=True))
        del normal, solution, parts  # memory
        before = fit.state.values
        fit = solve(model, fit.state, fit.noise, fit.anchor, steps=AGAIN, enough=FINE)
        moved = [np.abs(fit.state.values[n] - before[n]) / model.priors[n].std for n in model.tilts or {}]
        if max(float(m.max()) for m in moved) < STILL:
            break
    return fit


__all__ = ["settled", "unbiased"]
