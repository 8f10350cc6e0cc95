"""What a refit with effects that have a life of their own is worth, and when such a fit is one."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import LAW
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.shared import DECLARED_NOISE, EVIDENCE
from imubench.diagnosis.criteria.conditional_aic import aic_gain, aic_gain_and_freedoms
from imubench.diagnosis.criteria.plausible_fit import at_rest, law_levels
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.colour_bound import louder_where
from imubench.diagnosis.noise.looser_motion import rougher
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError


def trial_beside(fit: Fit, hypotheses: list[Hypothesis], tried: Fit) -> Trial:
    """Return a refit beside the fit without its effects; where its freedoms decide, its laws as tight as it bears."""
    loose, freedoms = judged(fit, hypotheses, tried)
    if not -freedoms < loose.evidence < LAW.decided * freedoms:
        return loose
    tight = tightened(tried, hypotheses)
    return loose if tight is None else max(loose, judged(fit, hypotheses, tight)[0], key=lambda t: t.evidence)


def tightened(fit: Fit, hypotheses: Sequence[Hypothesis]) -> Fit | None:
    """Return a fit with tighter laws of some effects; None where none is at its floor.

    There a state still follows some of the samples' noise, and pays for that freedom more than a tighter law would.
    """
    told = law_levels(fit, hypotheses)
    lower = {n: LAW.tighter * fit.noise[n] for n in told if REML.law_floor / 2 < fit.noise[n] < 2 * REML.law_floor}
    return with_noise(replace(fit, noise=fit.noise | lower), 2) if lower else None


def with_tight_laws(fit: Fit) -> Fit:
    """Return a fit with every law as tight as it bears."""
    for h in [h for h in fit.model.hypotheses if h.effect.lawful]:
        with suppress(NotPositiveDefiniteError):
            tight = tightened(fit, [h])
            if tight is not None and aic_gain(fit, tight) > -LAW.tighter_cost_nat:
                fit = tight
    return fit


def judged(fit: Fit, hypotheses: list[Hypothesis], tried: Fit) -> tuple[Trial, float]:
    """Return a refit beside the fit without its effects, less what a spline without a law may have of slow noise.

    With it come the freedoms that it pays for.

    A filter must explain something beside a rougher motion too: knowing which frequencies do not pass, it takes from
    the fit the freedom to follow noise there.
    """
    won, freedoms = aic_gain_and_freedoms(fit, tried)
    if won > EVIDENCE.needed_nat and any(h.effect.filters for h in hypotheses):
        beside = aic_gain(rougher(fit), rougher(tried))
        won = won if beside > EVIDENCE.needed_nat else min(won, beside)
    if won > 0 and not any(h.effect.lawful for h in hypotheses):
        won -= min(
            coloured_noise_gain(tried, hypotheses, freedoms),
            won * 2 * DECLARED_NOISE.colour / max(noise_power_taken(fit, tried), DECLARED_NOISE.colour),
        )
    return Trial(hypotheses[0], tried, won, tuple(hypotheses[1:])), freedoms


def noise_power_taken(before: Fit, after: Fit) -> float:
    """Return how much noise power a sensor has lost at most from one fit to the other, over what is left.

    What a spline gains grows faster than the power that it takes: noise that is at most half as coloured gives it at
    most half of that.
    """
    power = after.model.averaging.power
    return max(power(r.name, (before.noise[r.name] / after.noise[r.name]) ** 2) - 1 for r in after.measured)


def coloured_noise_gain(fit: Fit, hypotheses: Sequence[Hypothesis], freedoms: float) -> float:
    """Return the nat that splines may gain of noise as coloured as it may be without being a mismatch.

    Noise of `DECLARED_NOISE.colour` of the white one's power adds that share of a sample's freedom at each sample and
    each of their columns, however it is spread; and no more than their freedoms, each as loud as where they move the
    readings.
    """
    signals = added(fit, hypotheses)
    width = sum(s.width for h in hypotheses for s in h.effect.states)
    averaging = fit.model.averaging
    samples = float(np.median([len(time) / averaging.share(name) ** 2 for name, time, _ in signals]))
    return min(DECLARED_NOISE.colour * samples * width, freedoms * (louder_where(signals, {}, {}, averaging) - 1))


def added(fit: Fit, hypotheses: Sequence[Hypothesis]) -> list[tuple[str, Array, Array]]:
    """Return what the states of some effects add to the samples: a group, its times (n,), whitened (n m, 1)."""
    without = {r.name: r for r in fit.model.measured(at_rest(fit, hypotheses))}
    moved = {r.name: r.residual.value - without[r.name].residual.value for r in fit.rows if r.name in without}
    return [(name, without[name].time, x.reshape(-1, 1) / fit.noise[name]) for name, x in moved.items()]


__all__ = ["judged", "tightened", "trial_beside", "with_tight_laws"]
