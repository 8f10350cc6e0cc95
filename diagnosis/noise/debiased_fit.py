"""Springs whose numbers lean on no noise: as few knots as there may be, and every number pulled.

While names are sought, only stiffnesses and dampings are pulled (diagnosis/noise/debias.py). A lever arm leans as well:
what noise turns a rocking sensor by moves its sensing point, which explains noise of its accelerometer, and the arm
comes out too long. Here every number of a law is pulled until none moves any more.
"""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.noise import DEBIAS
from imubench.diagnosis.config.solve import ALGEBRA, SOLVER
from imubench.diagnosis.noise.debias import law_parameters, noise_pull
from imubench.diagnosis.noise.knot_selection import coarsest, finer
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.solve.gauss_newton import factored
from imubench.diagnosis.solve.levenberg_marquardt import search
from imubench.diagnosis.solve.threads import one_thread


def debiased(fit: Fit) -> Fit:
    """Return the fit with its laws' numbers pulled off what noise makes of them."""
    return settled(finer(coarsest(fit))) if law_parameters(fit) else fit


@one_thread
def settled(fit: Fit) -> Fit:
    """Return the fit at the noise levels that it has, every number of its laws pulled until all stay.

    Where noise says most of what seems to be known, a whole pull leads beyond and the next one back, further each time:
    after each turn pulls are halved.
    """
    share, last = 1.0, np.zeros(1)
    for turn in range(DEBIAS.rounds):
        normal, solution, parts = factored(fit.model, fit.rows)
        model = replace(fit.model, tilts=noise_pull(fit, normal, solution, parts, every=True, share=share))
        names = list(model.tilts or {})
        std = np.sqrt(np.diag(np.linalg.inv(solution.schur))[fit.model.parameters.places(names)])
        del normal, solution, parts  # memory
        before = fit.state.values
        fit = search(
            model,
            fit.state,
            fit.noise,
            fit.anchor,
            SOLVER.refit_steps if turn else SOLVER.steps,
            SOLVER.fine_gain,
            ALGEBRA.ridge,
        )[0]
        move = np.concatenate([fit.state.values[n] - before[n] for n in names]) / std
        if np.max(np.abs(move)) < DEBIAS.settled:
            break
        share, last = share / 2 if np.sum(move * last) < 0 else share, move
    return fit


__all__ = ["debiased", "settled"]
