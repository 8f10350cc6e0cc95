"""Every candidate effect scored from one fit: what it would explain, before anything is fitted anew.

With g the gradient of the negative log likelihood by an effect's parameters and M their information once the motion,
the geometry and the effects already in the model are free to move, its quadratic model predicts a gain of g' (M + L)^-1
g / 2, L the prior's information; its Laplace evidence subtracts log det(I + L^-1 M) / 2, the price of the freedom. (M +
L)^-1 is also the Cramer-Rao bound.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.problem.batch_model import started
from imubench.diagnosis.problem.bspline import Tracks
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import Parameters
from imubench.diagnosis.solve.gauss_newton import all_rows
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.schur import Base, promise, together
from imubench.diagnosis.solve.threads import one_thread
from imubench.jets import derivatives_by


@dataclass(frozen=True)
class Score:
    """What a hypothesis promises."""

    hypothesis: Hypothesis
    gain: float  # nat, of the log likelihood and prior
    evidence: float  # nat, the gain less the price of its freedom
    estimate: Array  # (k,) the parameters it would take, one linear step from the fit
    bound: Array  # (k,) their standard deviations


@one_thread
def score(fit: Fit, candidates: list[Hypothesis], base: Base | None = None) -> list[Score]:
    """Return the scores of effects without states, best evidence first; `base` has the fit's factored equations.

    Some at a time: the columns of all, of a long recording, would be more than all the rest that is held.
    """
    if not candidates:
        return []
    out = []
    for h, information, force in each(base or Base.of(fit), candidates):
        found = promise(information, force, prior_std(h))
        out.append(Score(h, found.gain, found.evidence, found.step, found.bound))
    return sorted(out, key=lambda s: -s.evidence)


def each(base: Base, candidates: Iterable[Hypothesis]) -> Iterator[tuple[Hypothesis, Array, Array]]:
    """Yield effects without states with the information (k, k) and the gradient (k,) of their own parameters."""
    for some in together(candidates, base.at_once):
        shared, information, force = reduced(base, some)
        for h in some:
            here = shared.places([h.key(p.name) for p in h.effect.parameters])
            yield h, information[np.ix_(here, here)], force[here]


def prior_std(h: Hypothesis) -> Array:
    """Return the standard deviation (k,) that the prior of an effect has for each of its numbers."""
    return np.concatenate([np.full(p.width, p.std) for p in h.effect.parameters])


def reduced(base: Base, some: Sequence[Hypothesis]) -> tuple[Parameters, Array, Array]:
    """Return the parameters of some effects without states, their information (k, k) and gradient (k,).

    Once motion, geometry and the effects of the fit have followed.
    """
    fit = base.fit
    model = fit.model.with_effects((*fit.model.hypotheses, *some))
    shared = Parameters({h.key(p.name): p.width for h in some for p in h.effect.parameters})
    with derivatives_by(shared.widths):
        rows = all_rows(model, started(model, fit.state), fit.noise, fit.anchor, fit.loose)
    only = Tracks(model.tracks.knots, {})
    moved = (r for r in rows if r.name in base.parts and r.residual.blocks)
    columns = ((r.name, linearise(r, only, shared).border) for r in moved)
    return shared, *base.reduced(columns, shared.count)


def at_best_size(values: Array, pull: Array, sizes: Iterable[float], louder: float = 1.0) -> tuple[float, float]:
    """Return the nat that weights win less the price of their freedom, and the size of their prior, that have most."""
    told = ((gain_of_weights(values, pull, size, louder), size) for size in sizes)
    return max(((won - price, size) for (won, price), size in told), key=lambda t: t[0])


def gain_of_weights(values: Array, pull: Array, std: float, louder: float = 1.0) -> tuple[float, float]:
    """Return the nat that weights with a prior `std` win, and the price of their freedom.

    `values`, `pull` (k,): eigenvalues of their information, squares of the gradient along its eigenvectors, with white
    noise. Noise so many times louder divides both: v / l and p / l^2 for v and p.
    """
    grown = louder + std**2 * np.maximum(values, 0.0)
    won = 0.5 * float(np.sum(std**2 * pull / grown)) / louder
    return won, 0.5 * float(np.sum(np.log(grown / louder)))
