"""Whether a fit's numbers may be believed: both halves of the recording tell the same, and nature knows such numbers.

A fit in the wrong basin has a low residual and numbers that one half takes from another cause than the other half does.
Each half's numbers are one Gauss-Newton step from those of the whole (`heldout`), with the covariance of that half, as
wide as the residuals' colour makes it. With d the difference of the halves' numbers and s its standard deviation, a
number is doubted where |d| > APART s and d is more than the number could be off and still serve (`SERVES`).
"""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.arrow import solve_arrow
from imubench.diagnosis.coloured import parameter_std
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.heldout import block_of
from imubench.diagnosis.linear import linearise
from imubench.diagnosis.normal import Normal
from imubench.diagnosis.refit import information
from imubench.diagnosis.swings import is_data
from imubench.diagnosis.threads import one_thread

APART = 4.0  # standard deviations: of fifty numbers, one recording in 300 has one that far apart by chance
UNNATURAL = 4.0  # standard deviations of a number's prior, which holds what is plausible
SERVES = {"rotation": 0.05, "translation": 0.02}  # rad, m: 3 deg and 2 cm of a mount move what a user asks for by less


@dataclass(frozen=True)
class Doubt:
    """A number that speaks against a fit."""

    name: str  # of the parameter, such as "imu1.rotation"
    why: str


@one_thread
def of_halves(fit: Fit) -> dict[str, tuple[Array, Array]]:
    """Return by how much every parameter (k,) differs between both halves of the recording, and the white-noise std."""
    start, end = fit.span
    model = fit.model
    rows = [(r, linearise(r, model.tracks, model.parameters)) for r in fit.rows]
    told = []
    for half in (0, 1):
        normal = Normal.empty(model.tracks, model.parameters)
        normal.add(
            [part.of(block_of(r.time, start, end, np.inf, 2) == half) if is_data(r) else part for r, part in rows]
        )
        normal.fill(model.tracks)
        solution = solve_arrow(normal.band, normal.border, normal.corner)
        _, step = solution.solve(-normal.gradient[:, :, None], -normal.corner_gradient[:, None])
        told.append((step[:, 0], np.diag(np.linalg.inv(solution.schur))))
        del normal, solution  # with their factors: memory
    (one, variance1), (two, variance2) = told
    apart, std = two - one, np.sqrt(variance1 + variance2)
    columns = model.parameters.columns
    return {name: (apart[columns(name)], std[columns(name)]) for name in model.priors}


def doubts(fit: Fit) -> list[Doubt]:
    """Return what speaks against a fit's numbers."""
    _, white = information(fit)
    coloured = parameter_std(fit)
    found = []
    for name, (apart, std) in of_halves(fit).items():
        wide = std * np.maximum(coloured[name] / white[name], 1.0)
        serves = SERVES.get(name.rpartition(".")[2], 0.0)
        k = int(np.argmax(np.abs(apart) / wide))
        if abs(apart[k]) > max(APART * wide[k], serves):
            found.append(Doubt(name, f"the halves differ by {apart[k]:.3g} +- {wide[k]:.2g}"))
    for h in fit.model.hypotheses:
        for p in h.effect.parameters:
            prior, value = fit.model.priors[h.key(p.name)], fit.state.values[h.key(p.name)]
            off = np.max(np.abs(value - prior.start) / prior.std)
            if off > UNNATURAL:
                found.append(Doubt(h.key(p.name), f"{off:.1f} standard deviations from what is plausible"))
    return found


__all__ = ["Doubt", "doubts", "of_halves"]
