"""A sensor that the motion follows nearly everywhere: what little is left of it may all be an effect's.

A lone gyroscope beside a pose is held by it below 1.5 Hz: of its 2,250 readings in 15 s at 50 Hz 66 are left to tell
its noise. An effect that takes half of what these hold raises the level to four times the declared one, and beside such
noise it is worth nothing (a g-sensitivity of 22 bounds: -6 nat; at the declared level 188, and the level falls to 0.85
of it). So effects are tried at the declared level as well, and count if they bring it down.
"""

from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.reml import declared, levels, with_noise
from imubench.diagnosis.problem.dynamics_factors import is_data
from imubench.diagnosis.solve.levenberg_marquardt import AGAIN, Fit, solve

FEW = 300  # readings that tell a level
LOUD = 1.5  # times the declared level


def uncertain_levels(fit: Fit) -> dict[str, float]:
    """Return the declared levels of sensors of which few readings tell the level, where that is too loud."""
    told = {n: std for n, std in declared(fit.model).items() if n in fit.noise and fit.noise[n] > LOUD * std}
    if not told:
        return {}
    leverage = levels(fit)[1]
    left = {r.name: r.residual.value.size - float(leverage[r.name].sum()) for r in fit.rows if is_data(r)}
    return {n: std for n, std in told.items() if left[n] < FEW}


def at_levels(fit: Fit, told: dict[str, float]) -> Fit:
    """Return the fit at those levels."""
    return solve(fit.model, fit.state, fit.noise | told, fit.anchor, steps=AGAIN)


def nearer_to_declared(fit: Fit, trial: Trial, told: dict[str, float]) -> bool:
    """Return whether the levels that a trial leaves are nearer to the declared ones than to those of a fit."""
    left = with_noise(trial.fit).noise
    return all(left[n] ** 2 < std * fit.noise[n] for n, std in told.items())


__all__ = ["at_levels", "nearer_to_declared", "uncertain_levels"]
