"""A sensor that the motion follows nearly everywhere: what little it leaves may all be an effect's.

A measured pose holds the motion up to some Hz; above, the motion follows a lone gyroscope, few of whose readings remain
to tell its noise. An effect that takes half of what these hold raises the estimated level far above the declared one,
and beside such noise the same effect is worth nothing. So effects are tried at the declared level as well, and count if
they bring the estimate down to it.
"""

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import DECLARED_NOISE
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.noise_levels import levels
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import is_data
from imubench.diagnosis.solve.levenberg_marquardt import solve


def uncertain_levels(fit: Fit) -> dict[str, float]:
    """Return the declared levels of sensors of which few readings tell the level, where that is too loud."""
    told = {
        n: std
        for n, std in declared(fit.model).items()
        if n in fit.noise and fit.noise[n] > DECLARED_NOISE.raised_std * std
    }
    if not told:
        return {}
    leverage = levels(fit)[1]
    left = {r.name: r.residual.value.size - float(leverage[r.name].sum()) for r in fit.rows if is_data(r)}
    return {n: std for n, std in told.items() if left[n] < ADMISSION.few_readings}


def at_levels(fit: Fit, told: dict[str, float]) -> Fit:
    """Return the fit at those levels."""
    return solve(fit.model, fit.state, fit.noise | told, fit.anchor, steps=SOLVER.few_steps)


def nearer_to_declared(fit: Fit, trial: Trial, told: dict[str, float]) -> bool:
    """Return whether the levels that a trial leaves are nearer to the declared ones than to those of a fit."""
    left = with_noise(trial.fit).noise
    return all(left[n] ** 2 < std * fit.noise[n] for n, std in told.items())


__all__ = ["at_levels", "nearer_to_declared", "uncertain_levels"]
