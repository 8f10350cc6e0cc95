"""How surely a spring's numbers are known: by what a fit would say of others that the recording allows.

How well a stiffness or a damping x is known depends on what it is. A spring without damping rings, and would show its
damping to a hundredth; one of 0.2 answers as one of 0.1 does. A stiff spring gives way less than a soft one. Where a
motion hardly makes a spring ring, noise may pull its damping to nothing, and the curvature there says how well a spring
that rings would be known instead. The interval of x (Neyman's) holds every larger x' from
which x is no further than fits of x' scatter, s(x') their deviation::

    (x' - x) / s(x') < 1.96,  and the fit held at x' costs little more,

so with the largest such x' the stated deviation is (x' - x) / 1.96. The spring's other numbers are no surer than
in any such fit.
"""

from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.noise import SPRING_INTERVAL
from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.gauss_newton import all_rows
from imubench.diagnosis.solve.levenberg_marquardt import solve

DAMPING, FREQUENCY = "damping_ratio", "frequency"
SURE_WITHIN = {DAMPING: 0.15, FREQUENCY: 0.04}  # of a number: where every axis is surer, nothing is asked


def with_spring_intervals(fit: Fit, std: dict[str, Array]) -> dict[str, Array]:
    """Return the standard deviations of a fit's numbers, wider where springs may be stiffer or ring less."""
    out = dict(std)
    for h in fit.model.hypotheses:
        for name in (p.name for p in h.effect.parameters if p.log and p.name in SURE_WITHIN):
            if np.any(std[h.key(name)] > SURE_WITHIN[name]):
                widen(out, fit, h, name)
    return out


def widen(out: dict[str, Array], fit: Fit, h: Hypothesis, name: str) -> None:
    """Widen the deviations `out` of a spring by what fits say that hold its number `name` at ever larger values."""
    key = h.key(name)
    own = np.exp(fit.state.values[key])
    last, scatter, asked = own, out[key] * own, np.ones(own.size, dtype=bool)
    for value in (
        [np.maximum(own, z) for z in SPRING_INTERVAL.dampings]
        if name == DAMPING
        else [own * k for k in SPRING_INTERVAL.stiffer]
    ):
        there = held_at(fit, key, value)
        if there.cost - fit.cost > EVIDENCE.certain_nat:
            break
        std = parameter_std(there)
        further = std[key] * value
        rise = (further - scatter) / np.maximum(value - last, 1e-9)  # of the scatter, straight in between
        end = last + (STATISTICS.interval_sigmas * scatter - (last - own)) / np.maximum(
            1 - STATISTICS.interval_sigmas * rise, 1e-9
        )
        inside = value - own < STATISTICS.interval_sigmas * further
        last = np.where(asked, np.where(inside, value, np.clip(end, last, value)), last)
        scatter, asked = further, asked & inside
        if np.all(asked):
            for other in (h.key(p.name) for p in h.effect.parameters if not p.log):
                out[other] = np.maximum(out[other], std[other])
    out[key] = np.maximum(out[key], (last - own) / (STATISTICS.interval_sigmas * own))


def held_at(fit: Fit, key: str, value: Array) -> Fit:
    """Return the fit with numbers (k,) of a spring held, solved for all else; its rows, as of a fit that finds them."""
    model = replace(fit.model, fixed={**(fit.model.fixed or {}), key: np.log(value)})
    done = solve(model, fit.state, fit.noise, fit.anchor, SOLVER.refit_steps)
    rows = all_rows(fit.model, done.state, fit.noise, fit.anchor, fit.loose)
    return replace(done, model=fit.model, loose=fit.loose, rows=rows)


__all__ = ["with_spring_intervals"]
