"""A late clock that is a filter: to first order both delay what a sensor reads, and a filter also flattens it.

The delay has no state and is found first; what it leaves may be too little for effects with states to be tried.
So every clock's offset is held against filters at the sensor that is late, begun at the cutoff 1 / (2 pi delay): one
far quicker than the motion as soon as the offset is known, any other once all effects are.

What a quick one does beside delaying is held, and taken from the motion of a fit that knew a delay alone: it is taken
again from the motion that the filter leaves. Of 9.4 Hz and 2,470 bounds a filter left 415 nat else, and came out as one
of 9.07 beside a clock 0.58 ms late.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.delays import filter_beyond_delay, late_imu
from imubench.diagnosis.criteria.effect_dynamics import driven_by_motion
from imubench.diagnosis.criteria.trial import Kept, Passed, Trial, misfit
from imubench.diagnosis.noise.nominal import rougher
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.levenberg_marquardt import Fit, solve
from imubench.diagnosis.solve.refit import extended, refit
from imubench.diagnosis.traits import CLOCK, FILTER
from imubench.effects import VARIANTS
from imubench.effects.bandwidth import QuickLowPass
from imubench.effects.timing import TIME_OFFSET
from imubench.recording import Imu

ROUNDS = 2  # of noise levels
FASTEST = 5.0  # times the rate: a filter beyond is a delay
AGAIN = 3  # times at most that what a quick filter does beside delaying is taken again


def clock_to_quick_filter(fit: Fit, kept: list[Kept], say: Callable[[str], None]) -> tuple[Fit, list[Kept]]:
    """Return the fit and its effects, a clock's offset changed for a filter far quicker than the motion if better."""
    return clock_to_filter(fit, kept, say, splines=False)


def clock_to_filter(
    fit: Fit, kept: list[Kept], say: Callable[[str], None], splines: bool = True
) -> tuple[Fit, list[Kept]]:
    """Return the fit and its effects, a clock's offset among them changed for a filter if that is better.

    Quick filters that are there already are taken again from the motion that all effects leave.
    Where much is left unexplained a filter's splines would take of that: there it must explain what is left as well.
    Without `splines` only filters are tried that have none. One that is neither better nor worse, or better only
    beside a motion as smooth, ties with the offset.
    """
    fit, kept = renewed(fit, kept)
    k = next((k for k in kept if k.hypothesis.effect.name == CLOCK), None)
    slow = k and late_imu(fit, k.hypothesis)
    if k is None or not slow or fit.model.wander:  # a pose whose errors last was smoothed: it is no ruler for a filter
        return fit, kept
    puzzling = misfit(fit) > ADMISSION.unexplained_misfit
    rest = tuple(h for h in fit.model.hypotheses if h != k.hypothesis)
    settled = at_the_late(fit, k.hypothesis, *slow)
    if settled is None:
        return fit, kept
    moved = replace(k, hypothesis=replace(k.hypothesis, at=slow[0].name))
    cutoff = 1 / (2 * np.pi * max(slow[1], 1e-9))
    known = filter_beyond_delay(settled, *slow) if cutoff < FASTEST * slow[0].rate else None
    stateful = [e for e in VARIANTS if e.name == FILTER and cutoff < slow[0].rate and (e.variant or not known)]
    effects = ([known] if known else []) + (stateful if splines else [])
    if not effects:
        return fit, kept
    fit, k, kept = settled, moved, [moved if other is k else other for other in kept]
    plain = rougher(fit)
    tries: list[Trial] = []
    ties: list[Passed] = []
    for effect in effects:
        h = Hypothesis(effect, slow[0].name)
        say(f"trying {h.name} in the place of {k.hypothesis.name}")
        with suppress(NotPositiveDefiniteError):
            tried = _with(fit, rest, h, {h.key("cutoff"): np.array([np.log(cutoff)])})
            tried, h = taken_again(tried, h) if effect is known else (tried, h)
            smooth, rough = gains((fit, plain), tried)
            tries.append(Trial(h, tried, min(smooth, rough)))
            ties += [Passed(h, tries[-1].evidence)] if max(smooth, rough) > -EVIDENCE.needed_nat else []
    best = max(tries, key=lambda t: t.evidence, default=None)
    if (
        best is None
        or best.evidence <= EVIDENCE.needed_nat
        or (puzzling and misfit(best.fit) > ADMISSION.unexplained_misfit)
    ):
        tied = k if puzzling else replace(k, ties=tuple(ties))
        return fit, [tied if other is k else other for other in kept]
    rivals = (Passed(k.hypothesis, k.evidence), *k.rivals)
    new = replace(k, hypothesis=best.hypothesis, evidence=k.evidence + best.evidence, rivals=rivals)
    return best.fit, [new if other is k else other for other in kept]


def renewed(fit: Fit, kept: list[Kept]) -> tuple[Fit, list[Kept]]:
    """Return the fit and its effects, quick filters taken again from the motion that all effects leave."""
    for k in [k for k in kept if isinstance(k.hypothesis.effect, QuickLowPass)]:
        with suppress(NotPositiveDefiniteError):
            fit, h = taken_again(fit, k.hypothesis)
            kept = [replace(k, hypothesis=h) if other is k else other for other in kept]
    return fit, kept


def taken_again(fit: Fit, h: Hypothesis) -> tuple[Fit, Hypothesis]:
    """Return a fit and its quick filter, what that does beside delaying from the motion it leaves, while that gains."""
    imu, rest = fit.model.recording.imu(h.at), tuple(other for other in fit.model.hypotheses if other != h)
    clock, found = Hypothesis(TIME_OFFSET, h.at), fit
    for _ in range(AGAIN):
        cutoff = found.state.values[h.key("cutoff")]
        delay = 1 / (2 * np.pi * np.exp(cutoff))
        effect = filter_beyond_delay(
            extended(found, (*rest, clock), {clock.key("offset"): delay}), imu, float(delay[0])
        )
        if effect is None:
            break
        new = Hypothesis(effect, h.at)
        tried = refit(found, (*rest, new), {new.key("cutoff"): cutoff})
        if found.cost - tried.cost < EVIDENCE.needed_nat:
            break
        found, h = tried, new
    return (fit if found is fit else with_noise(found, ROUNDS)), h


def at_the_late(fit: Fit, h: Hypothesis, imu: Imu, delay: float) -> Fit | None:
    """Return a fit in which a clock's offset is that of the IMU that is late; None where there is none.

    With two clocks and nothing else either may be off. But where the samples of one lie between the other's is settled
    by it, and with that how much of the noise the motion takes in: 44 nat against the filter of an unseen trial, 0 so.
    """
    if h.at == imu.name:
        return fit
    there = replace(h, at=imu.name)
    rest = tuple(other for other in fit.model.hypotheses if other != h)
    with suppress(NotPositiveDefiniteError):
        return _with(fit, rest, there, {there.key("offset"): np.array([delay])})
    return None


def gains(before: tuple[Fit, Fit], tried: Fit) -> tuple[float, float]:
    """Return the nat by which a filter predicts the samples better than a fit, as smooth and (the second) rougher.

    What a filter does beside a delay goes with the motion's second derivative, as what a motion held too smooth leaves.
    """
    return aic_gain(before[0], tried), aic_gain(before[1], rougher(tried))


def _with(fit: Fit, rest: tuple[Hypothesis, ...], h: Hypothesis, start: dict[str, Array]) -> Fit:
    begun = extended(fit, (*rest, h), start)
    tried = solve(begun.model, driven_by_motion(begun.model, begun.state, [h]), begun.noise, fit.anchor, steps=6)
    return with_noise(tried, ROUNDS)
