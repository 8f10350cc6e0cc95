"""What effects promise at the size that they have, not at the largest that they may have.

With M an effect's information and g its gradient in units of its prior, everything else free to follow,

    e(s) = g' (M + 1/s^2)^-1 g / 2 - log det(I + s^2 M) / 2,

the most of it over sizes s.
"""

from collections.abc import Sequence

import numpy as np

from imubench.diagnosis.criteria.score_test import at_best_size, each, prior_std
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, linear_in
from imubench.diagnosis.solve.schur import Base
from imubench.diagnosis.solve.threads import one_thread

SIZES_OF_PRIOR = tuple(
    float(s) for s in 10.0 ** np.arange(-3.0, 3.0, 0.5)
)  # of an effect's prior, or of a term's weights


@one_thread
def scores_at_size(base: Base, some: Sequence[Hypothesis]) -> dict[Hypothesis, tuple[float, float]]:
    """Return the nat that each effect without states promises at its best size, and that size."""
    out = {}
    for h, information, gradient in each(base, some):
        std = prior_std(h)
        values, vectors = np.linalg.eigh(information * np.outer(std, std))
        pull = (vectors.T @ (gradient * std)) ** 2
        out[h] = at_best_size(values, pull, SIZES_OF_PRIOR)
    return out


def gain_at_size(without: Fit, gone: Sequence[Hypothesis], lost: float) -> float:
    """Return the nat that one name near linear, worth `lost` in a fit, gains at the size that it has; 0 for others.

    A term's weights are as large as they explain most. An effect whose prior is far wider than its number pays for that
    width; a term that has one weight for all axes does not, and would take its place.
    """
    if len(gone) > 1 or not linear_in(gone[0]):
        return 0.0
    return max(scores_at_size(Base.of(without), gone)[gone[0]][0] - lost, 0.0)


__all__ = ["SIZES_OF_PRIOR", "gain_at_size", "scores_at_size"]
