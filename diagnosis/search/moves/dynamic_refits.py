"""How a refit begins with effects that have a life of their own."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.criteria.dynamic_aic import trial_beside
from imubench.diagnosis.criteria.dynamic_score import Screened
from imubench.diagnosis.criteria.effect_dynamics import driven_by_motion
from imubench.diagnosis.criteria.plausible_fit import law_levels
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.reml import fit_with_noise, with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.gauss_newton import all_rows, extended
from imubench.diagnosis.solve.levenberg_marquardt import settled, solve


def refit_from_screening(fit: Fit, some: list[Screened], rounds: int = REML.rounds) -> Trial:
    """Return the refit with state effects, begun as their laws say and where a law outweighs the measurements.

    From the screening's stiff and damped starts: the motion of a fit that knows no spring holds the spring's own, and
    a law already tuned to it would answer with a resonance.
    """
    hypotheses = [s.hypothesis for s in some]
    guess = {name: value for s in some for name, value in s.values.items()}
    begun = extended(fit, (*fit.model.hypotheses, *hypotheses), guess)
    noise = dict(begun.noise)
    for s in some:
        noise |= s.noise
    start = calm_for_laws(replace(begun, noise=noise), hypotheses)
    tried = solve(begun.model, driven_by_motion(begun.model, begun.state, hypotheses), start, fit.anchor, steps=4)
    tried = with_noise(tried, rounds)
    return trial_beside(fit, hypotheses, tried)


def refit_beside(fit: Fit, alone: Trial, other: Screened) -> Trial:
    """Return the refit with a second state effect, begun where the first alone had come to."""
    h, found = other.hypothesis, alone.fit
    guess = {name: value for name, value in found.state.values.items() if name not in fit.model.priors}
    begun = extended(found, (*found.model.hypotheses, h), guess | dict(other.values))
    noise = begun.noise | found.noise | other.noise
    tried = solve(begun.model, driven_by_motion(begun.model, begun.state, [h]), noise, fit.anchor, steps=4)
    tried = with_noise(tried, REML.rounds)
    return trial_beside(fit, [alone.hypothesis, h], tried)


def on_whole_recording(fit: Fit, trial: Trial) -> Trial:
    """Return a trial on a part of the recording as one on all of it, from the parameters and the noise found there."""
    hypotheses = [trial.hypothesis, *trial.also]
    guess = {name: value for name, value in trial.fit.state.values.items() if name not in fit.model.priors}
    begun = extended(fit, (*fit.model.hypotheses, *hypotheses), guess)
    laws_loose = {n: begun.noise[n] for n in law_levels(begun, hypotheses)}
    noise = begun.noise | trial.fit.noise | laws_loose
    quiet = calm_for_laws(replace(begun, noise=noise), hypotheses)
    # by a motion that holds the spring's own, it may resound
    driven = driven_by_motion(begun.model, begun.state, hypotheses)
    states = [begun.state, driven]
    states += [settled(begun.model, s, quiet, fit.loose) for s in states]
    cost = [sum(r.cost for r in all_rows(begun.model, s, quiet, fit.anchor, fit.loose)) for s in states]
    begun = solve(begun.model, states[int(np.argmin(cost))], quiet, fit.anchor, steps=4)
    tried = fit_with_noise(begun.model, begun.state, noise, fit.anchor, rounds=REML.rounds)
    return trial_beside(fit, hypotheses, tried)


def calm_for_laws(fit: Fit, hypotheses: Sequence[Hypothesis]) -> dict[str, float]:
    """Return the fit's noise levels, calm where an effect has a law to outweigh a misfit; a free state would vanish."""
    return calm(fit) if any(h.effect.lawful for h in hypotheses) else fit.noise


def calm(fit: Fit) -> dict[str, float]:
    """Return noise levels to begin a spring's fit with: ten times the declared, so that its law outweighs a misfit."""
    told = declared(fit.model)
    return {name: 10 * told[name] if name in told else std for name, std in fit.noise.items()}


__all__ = ["calm_for_laws", "on_whole_recording", "refit_beside", "refit_from_screening"]
