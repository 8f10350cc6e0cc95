"""A late clock that is a filter: to first order both delay what a sensor reads, and a filter also flattens it.

The delay has no state and is found first; what it leaves may be too little for effects with states to be tried. So
every clock's offset is held against filters at the sensor that is late, begun at the cutoff 1 / (2 pi delay): one far
quicker than the motion as soon as the offset is known, any other once all effects are.

What a quick one does beside delaying is held, and computed from the motion of a fit that knew a delay alone. It is
computed again from the motion that the filter leaves; else part of a slow filter stays in the motion, and comes out as
a clock beside a filter that is too slow.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.delays import filter_beyond_delay, late_imu
from imubench.diagnosis.criteria.effect_dynamics import driven_by_motion
from imubench.diagnosis.criteria.trial import Kept, Passed, Trial
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.noise.looser_motion import rougher
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.move import Above, Holds, Proposal, Proposals, SearchState
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import refit
from imubench.effects import VARIANTS, delay_law
from imubench.effects.effect import Effect
from imubench.progress import tell
from imubench.recording import Imu

FASTEST = 5.0  # times the rate: a filter beyond is a delay
AGAIN = 3  # times at most that what a quick filter does beside delaying is taken again


@dataclass(frozen=True)
class ClockToFilter:
    """A filter in the place of a clock's offset among the effects, if that is better.

    Where much is left unexplained a filter's splines would take of that: there it must explain what is left as well.
    Without `splines` only filters are tried that have none, far quicker than the motion. One that is neither better nor
    worse, or better only beside a motion as smooth, ties with the offset.
    """

    splines: bool = True

    def propose(self, state: SearchState) -> Proposals:
        """Yield the best filter; then, in its place, the offset at the IMU that is late, and what ties with it."""
        fit, kept = state.fit, state.kept
        k = next((k for k in kept if k.hypothesis.effect.late_by), None)
        slow = k and late_imu(fit, k.hypothesis)
        if k is None or not slow or fit.model.wander:  # a pose whose errors last was smoothed: no ruler for a filter
            return
        puzzling = misfit(fit) > ADMISSION.unexplained_misfit
        rest = tuple(h for h in fit.model.hypotheses if h != k.hypothesis)
        settled = at_the_late(fit, k.hypothesis, *slow)
        if settled is None:
            return
        moved = replace(k, hypothesis=replace(k.hypothesis, at=slow[0].name))
        known, effects = filters(settled, *slow, self.splines)
        if not effects:
            return
        tries, ties = self.tried(settled, rest, moved.hypothesis, slow, known, effects)
        best = max(tries, key=lambda t: t.evidence, default=None)
        if best is not None:
            new = replace(
                moved,
                hypothesis=best.hypothesis,
                evidence=k.evidence + best.evidence,
                rivals=(Passed(moved.hypothesis, k.evidence), *k.rivals),
            )
            answer = yield Proposal(
                f"{best.hypothesis.name} in the place of {moved.hypothesis.name}",
                state.changed(best.fit, put(new, k, kept)),
                (
                    Above(lambda: best.evidence, EVIDENCE.needed_nat),
                    Holds(lambda: not puzzling or misfit(best.fit) <= ADMISSION.unexplained_misfit),
                ),
            )
            if answer.accepted:
                return
        if settled is not fit or (not puzzling and (ties or k.ties)):
            tied = moved if puzzling else replace(moved, ties=tuple(ties))
            yield Proposal(f"{tied.hypothesis.name}, and what ties with it", state.changed(settled, put(tied, k, kept)))

    def tried(
        self,
        fit: Fit,
        rest: tuple[Hypothesis, ...],
        clock: Hypothesis,
        slow: tuple[Imu, float],
        known: Effect | None,
        effects: Sequence[Effect],
    ) -> tuple[list[Trial], list[Passed]]:
        """Return a fit with each filter in the place of a clock's offset, and which of them tie with that."""
        imu, delay = slow
        plain = rougher(fit)
        tries: list[Trial] = []
        ties: list[Passed] = []
        for effect in effects:
            h = Hypothesis(effect, imu.name)
            tell(f"trying {h.name} in the place of {clock.name}")
            with suppress(NotPositiveDefiniteError):
                tried = _with(fit, rest, h, {h.key("cutoff"): np.array([np.log(cutoff_of(delay))])})
                tried, h = taken_again(tried, h) if effect is known else (tried, h)
                smooth, rough = gains((fit, plain), tried)
                tries.append(Trial(h, tried, min(smooth, rough)))
                ties += [Passed(h, tries[-1].evidence)] if max(smooth, rough) > -EVIDENCE.needed_nat else []
        return tries, ties


def filters(fit: Fit, imu: Imu, delay: float, splines: bool) -> tuple[Effect | None, list[Effect]]:
    """Return the quick filter that delays as an IMU is late, if it is one, and all filters that are tried for it."""
    cutoff = cutoff_of(delay)
    known = filter_beyond_delay(fit, imu, delay) if cutoff < FASTEST * imu.rate else None
    stateful = [e for e in VARIANTS if e.filters and cutoff < imu.rate and (e.variant or not known)]
    return known, [*([known] if known else []), *(stateful if splines else [])]


def cutoff_of(delay: float) -> float:
    """Return the cutoff in Hz of a filter that delays by so many s."""
    return float(1 / (2 * np.pi * max(delay, 1e-9)))


def put(new: Kept, old: Kept, kept: Sequence[Kept]) -> list[Kept]:
    """Return effects with one in the place of another."""
    return [new if other is old else other for other in kept]


def taken_again(fit: Fit, h: Hypothesis) -> tuple[Fit, Hypothesis]:
    """Return a fit and its quick filter, what that does beside delaying from the motion it leaves, while that gains."""
    imu, rest = fit.model.recording.imu(h.at), tuple(other for other in fit.model.hypotheses if other != h)
    clock, found = Hypothesis(delay_law(), h.at), fit
    for _ in range(AGAIN):
        cutoff = found.state.values[h.key("cutoff")]
        delay = 1 / (2 * np.pi * np.exp(cutoff))
        effect = filter_beyond_delay(
            extended(found, (*rest, clock), {clock.key(clock.effect.late_by): delay}), imu, float(delay[0])
        )
        if effect is None:
            break
        new = Hypothesis(effect, h.at)
        tried = refit(found, (*rest, new), {new.key("cutoff"): cutoff})
        if found.cost - tried.cost < EVIDENCE.needed_nat:
            break
        found, h = tried, new
    return (fit if found is fit else with_noise(found, REML.rounds)), h


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
    return with_noise(tried, REML.rounds)
