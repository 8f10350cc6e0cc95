"""How large the noise of a solved fit really is: each group's level by restricted maximum likelihood.

A fit with as many freedoms as samples leaves residuals smaller than the noise. With the leverage h of
each row (the diagonal of the hat matrix), s^2 = sum r^2 / (n - sum h) is unbiased; the same rule gives the
roughness of the motion from the rows that hold it smooth.
"""

from collections.abc import Collection
from weakref import WeakKeyDictionary

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import is_data
from imubench.diagnosis.solve.bordered import Solution
from imubench.diagnosis.solve.gauss_newton import factored
from imubench.diagnosis.solve.linearize import Linear
from imubench.diagnosis.solve.marginals import Marginals
from imubench.diagnosis.solve.threads import one_thread

Levels = tuple[dict[str, float], dict[str, Array]]
_known: WeakKeyDictionary[Fit, Levels] = WeakKeyDictionary()


@one_thread
def levels(fit: Fit) -> Levels:
    """Return the noise level of every group that `fit.noise` names, and the leverage of its rows and of all data.

    Not to be written to: of a fit that is not too long they are kept as long as it is. Ten refits are held against one.
    """
    if fit in _known:
        return _known[fit]
    _, solution, parts = factored(fit.model, fit.rows)
    found = levels_of(fit, solution, parts, fit.noise.keys() | {r.name for r in fit.rows if is_data(r)})
    if fit.model.tracks.knots.count <= ALGEBRA.knots_beside:
        _known[fit] = found
    return found


def levels_of(fit: Fit, solution: Solution, parts: list[Linear], names: Collection[str]) -> Levels:
    """Return the same of some groups alone, from the factored equations of the fit and the rows that made them."""
    chosen = [(rows, part) for rows, part in zip(fit.rows, parts, strict=True) if rows.name in names]
    covariance = Marginals.of(solution, fit.model.tracks.width)
    out, hats = {}, {}
    for (rows, _), hat in zip(chosen, covariance.leverages([part for _, part in chosen]), strict=True):
        hats[rows.name] = hat
        if rows.name in fit.noise:
            free = max(rows.residual.value.size - float(hat.sum()), 1.0)
            out[rows.name] = max(fit.noise[rows.name] * fit.loose * np.sqrt(2 * rows.cost / free), REML.smallest)
    return out, hats
