"""Numbers that were learned on other samples than they are judged on.

The recording is cut into two halves. Where several free swings are declared, every other one is of one half, and each
stretch between them is cut in two; so is a single swing, and a recording without any. A stretch is cut where half of
its motion is over, by the square of the rate: a swing that friction stops shows in its second minute nothing. So both
halves have what shows a torque, and a roll-out begins anew with its half, from the state at its start.

Each half's parameters are one Gauss-Newton step from those of the whole (as in `cross_validation`): exact where the
rows are linear in them, and off by the square of a step of some standard deviations where they are not. The motion is
then solved for again, on all samples, with the other half's parameters held and springs and filters held to their laws.
It begins where that step leads it, or where it was, whichever costs less: of a declared model that leaves much, one
step may lead anywhere. The state at the start of a swing, and the motion of a hand, belong to the samples that are
judged: nothing else could tell them.

Some numbers only one half can tell: when a sensor slipped, how a stop gives way that is met once. Where a half knows a
number `SIMULATED_BESIDE.tells` times worse than the other half does, the number is that of the whole, and the
simulation says that it is not held out.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.simulation import SIMULATED_BESIDE
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.criteria.cross_validation import half_step
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.process_factors import law_rows, scenes
from imubench.diagnosis.problem.residuals import is_data
from imubench.diagnosis.solve.gauss_newton import all_rows
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.diagnosis.solve.retract import moved
from imubench.diagnosis.solve.threads import one_thread
from imubench.diagnosis.windows import Window, cut_out
from imubench.effects.effect import Effect
from imubench.recording import Recording, span_of


@dataclass(frozen=True)
class Part:
    """A stretch of a recording and the half that it belongs to."""

    start: float  # s, the recording's clock
    end: float  # s
    half: int  # 0 or 1
    swings: bool = False  # whether it lies in a free swing


@dataclass(frozen=True)
class Learned:
    """A fit with the numbers that another half has taught."""

    fit: Fit  # all samples' motion under these numbers
    told: NDArray[np.bool_]  # which of the numbers (p,) were learned there

    @property
    def held_out(self) -> bool:
        """Whether all of them were learned there."""
        return bool(self.told.all())


def parts_of(recording: Recording, swings: tuple[Window, ...]) -> tuple[Part, ...]:
    """Return the parts of a recording with free `swings` (s) from its first to its last stamp, in their order."""
    time, power = squared_rates(recording)
    span = float(time[0]), float(time[-1])
    swings = tuple(sorted((max(a, span[0]), min(b, span[1])) for a, b in swings if b > span[0] and a < span[1]))

    def halved(window: Window, swing: bool) -> list[Part]:
        cut = half_way(time, power, window)
        return [Part(window[0], cut, 0, swing), Part(cut, window[1], 1, swing)]

    out = [part for gap in cut_out([span], swings) for part in halved(gap, False)]
    if len(swings) == 1:
        out += halved(swings[0], True)
    else:
        out += [Part(*window, i % 2, True) for i, window in enumerate(swings)]
    return tuple(sorted(out, key=lambda part: part.start))


def squared_rates(recording: Recording) -> tuple[Array, Array]:
    """Return times (n,) s from the first to the last stamp, and the squared rates that are measured there (n,)."""
    time = np.linspace(*span_of(recording), SIMULATED_BESIDE.most_times)
    power = np.zeros(SIMULATED_BESIDE.most_times)
    for imu in recording.imus:
        power += np.interp(time, imu.time, np.sum(imu.gyro**2, axis=1))
    for encoder in recording.encoders:
        power += np.gradient(np.interp(time, encoder.time, encoder.angle), time) ** 2
    return time, power


def half_way(time: Array, power: Array, window: Window) -> float:
    """Return when half of a window's motion is over, at least `SIMULATED_BESIDE.least_half` from its ends."""
    inside = (time >= window[0]) & (time <= window[1])
    low, high = (
        window[0] + share * (window[1] - window[0])
        for share in (SIMULATED_BESIDE.least_half, 1 - SIMULATED_BESIDE.least_half)
    )
    total = np.cumsum(power[inside])
    if not total.size or not total[-1] > 0:
        return (window[0] + window[1]) / 2
    return float(np.clip(time[inside][np.searchsorted(total, total[-1] / 2)], low, high))


def half_at(parts: tuple[Part, ...], time: Array) -> NDArray[np.int64]:
    """Return the half (n,) that each time (n,) s belongs to."""
    place = np.searchsorted([part.start for part in parts], time, side="right") - 1
    return np.array([part.half for part in parts], dtype=np.int64)[np.clip(place, 0, len(parts) - 1)]


@one_thread
def learned(fit: Fit, parts: tuple[Part, ...]) -> tuple[Learned, Learned]:
    """Return a fit twice: with numbers for judging half 0, learned on half 1, and the reverse.

    Raises:
        NotPositiveDefiniteError: where a half does not hold the motion.
        OutOfTime: where the time of the part of the work is spent.
    """
    model = fit.model
    if not model.parameters.count:
        return Learned(fit, np.ones(0, dtype=bool)), Learned(fit, np.ones(0, dtype=bool))
    linear = [(is_data(r), r.time + model.start, linearise(r, model.tracks, model.parameters)) for r in fit.rows]
    steps, stds = [], []
    for half in (0, 1):
        own = [part.of(half_at(parts, time) == half) if data else part for data, time, part in linear]
        normal = Normal.of(model.tracks, model.parameters, own)
        _, step, _, known = half_step(normal)
        steps.append(step)
        stds.append(np.sqrt(np.diag(np.linalg.inv(known))))
        del normal  # with its factors, before the next one's: memory
    whole = half_step(Normal.of(model.tracks, model.parameters, [part for _, _, part in linear]))
    step, out = whole[1], []
    for half in (0, 1):
        told = stds[1 - half] <= SIMULATED_BESIDE.tells * stds[half]
        taught = np.where(told, steps[1 - half], step)
        out.append(Learned(_held(fit, _followed(fit, whole, taught)), told))
    return out[0], out[1]


def held_at(fit: Fit, numbers: Array) -> Fit:
    """Return a fit with numbers (p,) held, its motion solved for again and its springs and filters held to their laws.

    Raises:
        OutOfTime: where the time of the part of the work is spent.
    """
    return _held(fit, followed(fit, numbers - numbers_of(fit)))


def _held(fit: Fit, start: State) -> Fit:
    held = replace(fit.model, fixed=dict(start.values))
    return solve(held, start, with_laws_held(fit), fit.anchor, steps=SOLVER.few_steps)


def numbers_of(fit: Fit) -> Array:
    """Return the numbers (p,) of a fit in the order of its parameters."""
    return np.concatenate([np.zeros(0), *(fit.state.values[name] for name in fit.model.parameters.widths)])


@one_thread
def followed(fit: Fit, taught: Array) -> State:
    """Return a fit's state after a step of its parameters (p,), the motion along by the linearised equations.

    Where these lead to a motion that costs more than that of the fit does, it stays.
    """
    model = fit.model
    linear = [linearise(r, model.tracks, model.parameters) for r in fit.rows]
    return _followed(fit, half_step(Normal.of(model.tracks, model.parameters, linear)), taught)


def _followed(fit: Fit, whole: tuple[Array, Array, Array, Array], taught: Array) -> State:
    motion, step, follow, _ = whole
    ways = [moved(fit.model, fit.state, x, taught) for x in (motion + follow @ (taught - step), 0 * motion)]
    return min(ways, key=lambda way: sum(r.cost for r in all_rows(fit.model, way, fit.noise, fit.anchor, fit.loose)))


def with_laws_held(fit: Fit) -> dict[str, float]:
    """Return a fit's noise levels with the laws of springs and filters held closely, as a simulation integrates them.

    A fit estimates how far its states may be from their law, and what they are off by no replay can follow. Not of
    states that follow from the motion by no equation, as the play of a backlash: their rows only approximate that.
    """
    state = {
        rows.name
        for h, scene in scenes(fit.model, fit.state)
        if h.effect.lawful and type(h.effect).follow is Effect.follow
        for rows in law_rows(fit.model, fit.state, h, scene)
    }
    return {name: min(std, SIMULATED_BESIDE.law_std) if name in state else std for name, std in fit.noise.items()}


__all__ = [
    "Learned",
    "Part",
    "followed",
    "half_at",
    "held_at",
    "learned",
    "numbers_of",
    "parts_of",
    "with_laws_held",
]
