"""MuJoCo's simulations beside the recording: the declared model, and the model with all findings.

Both are played twice, once for each half of the recording, with numbers from the other half (`learned`). Inside free
swings they are rolled out by forces alone from the fitted state at the window's start (`rollout`), both over the same
windows; elsewhere the motion that was recovered under the respective model is prescribed, and what is sprung, loose or
late moves by its law.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.budget import check
from imubench.diagnosis.evidence import Comparison, Swing
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.hypothesis import Hypothesis
from imubench.diagnosis.refit import extended
from imubench.diagnosis.result import SimulatedChannel, Simulation
from imubench.diagnosis.simulation.channels import (
    ENDS,
    Channel,
    channels,
    dense_rate,
    read_out,
    simulated,
    span_of,
)
from imubench.diagnosis.simulation.learned import Learned, Part, half_at, learned, parts_of
from imubench.diagnosis.simulation.rollout import LEAST_S, Misfit, can_swing, horizon, refined
from imubench.diagnosis.simulation.sim_model import SimModel, named, playable, sim_model, state_at
from imubench.diagnosis.simulation.splice import rolled_truth
from imubench.diagnosis.simulation.windows import free
from imubench.diagnosis.windows import Window, covered
from imubench.recording import Recording

MOST = 3  # channels that are shown of a finding
COARSE = 200.0  # rows a second while a start is looked for: cubics between them are off by 1e-5 rad/s at swings' rates
LONG_STEP = 2.5e-3  # s, of the integration meanwhile: Runge and Kutta's error is 1e-8 rad in a second


@dataclass(frozen=True)
class Beside:
    """What MuJoCo says of a recording."""

    simulation: Simulation
    channels: tuple[Comparison, ...]  # every channel: the declared model, and the one with all findings
    findings: Mapping[tuple[str, str], tuple[Comparison, ...]]  # by effect and place: without it, and with it
    windows: tuple[Swing, ...]  # that a replay rolls out, with the states of the whole fit


@dataclass(frozen=True)
class Judge:
    """A recording, and where and how models are held against it."""

    recording: Recording
    channels: tuple[Channel, ...]
    counts: Mapping[str, NDArray[np.bool_]]  # by channel: samples (n,) that are a measurement
    noise: Mapping[str, float]  # std by group
    parts: tuple[Part, ...]
    windows: tuple[tuple[Window, ...], tuple[Window, ...]]  # that are rolled out, by half

    def misfit(self, model: SimModel) -> Misfit:
        """Return a function of a window: its samples' times, and simulated minus measured over the noise."""

        def of(window: Swing) -> tuple[Array, Array]:
            check()
            truth = rolled_truth(model.rig, window, COARSE, step=LONG_STEP)
            read = read_out(model, self.recording, truth, window.start)
            times, off = [], []
            margin = ENDS / COARSE
            for c in self.channels:
                own = (c.time >= window.start + margin) & (c.time <= window.end - margin) & self.counts[c.name]
                times.append(c.time[own])
                off.append((read[c.name] - c.measured)[own] / self.noise[c.group])
            return np.concatenate(times), np.concatenate(off)

        return of

    def played(self, one: Learned, half: int, started: Sequence[Swing] | None = None) -> dict[str, Array]:
        """Return every channel as one half's model plays it, from the states in `started` where they are known."""
        check()
        model = sim_model(one.fit)
        if started is None:
            started = [self.started(one.fit, model, span) for span in self.windows[half]]
        return simulated(model, self.recording, tuple(started))

    def started(self, fit: Fit, model: SimModel, span: Window) -> Swing:
        """Return a window with the fitted state at its start."""
        return refined(model.rig, Swing(*span, state_at(fit, span[0])), self.misfit(model))

    def whole(self, halves: tuple[Learned, Learned], started: Sequence[Sequence[Swing]] = ()) -> dict[str, Array]:
        """Return every channel, each half of the recording as it is played for that."""
        known = started or (None, None)
        both = [self.played(one, half, known[half]) for half, one in enumerate(halves)]
        return {
            c.name: np.where(half_at(self.parts, c.time) == 0, both[0][c.name], both[1][c.name]) for c in self.channels
        }

    def judged(self) -> tuple[Window, ...]:
        """Return the windows that are judged: those that are rolled out, or everything where none is."""
        rolled = tuple(sorted(span for half in self.windows for span in half))
        return rolled or ((self.parts[0].start, self.parts[-1].end),)

    def inside(self, channel: Channel) -> NDArray[np.bool_]:
        """Return which samples (n,) of a channel are judged."""
        margin = ENDS / dense_rate(self.recording) if any(self.windows) else 0.0
        windows = [(start + margin, end - margin) for start, end in self.judged()]
        return self.counts[channel.name] & covered(channel.time, windows)

    def off(self, channel: Channel, before: Array, after: Array) -> SimulatedChannel:
        """Return how far two simulations (n,) are from a channel."""
        own = self.inside(channel)
        rms = [float(np.sqrt(np.mean((x - channel.measured)[own] ** 2))) if own.any() else 0.0 for x in (before, after)]
        return SimulatedChannel(channel.unit, rms[0], rms[1], self.noise[channel.group])

    def gain(self, channel: Channel, before: Array, after: Array) -> float:
        """Return by how much the second of two simulations (n,) is nearer to a channel, as power over noise power."""
        off = self.off(channel, before, after)
        return (off.before**2 - off.after**2) / off.noise**2

    def compared(
        self, channel: Channel, before: Mapping[str, Array], after: Mapping[str, Array], models: Iterable[Learned]
    ) -> Comparison:
        """Return a channel beside two simulations."""
        told = all(one.held_out for one in models)
        span = ((self.parts[0].start, self.parts[-1].end),)
        values = channel.measured, before[channel.name], after[channel.name]
        noise = self.noise[channel.group]
        return Comparison(channel.name, channel.unit, channel.time, *values, noise, span if told else ())


def beside(
    recording: Recording,
    declared: Fit,
    best: Fit,
    noise: Mapping[str, float],
    others: Mapping[tuple[str, str], Fit],
) -> Beside | None:
    """Return what MuJoCo says of a recording under two models; None where it cannot play what the fit has in it.

    Args:
        recording: as it is held against the models, without what the raw checks took out of it.
        declared: the fit of the model as it was declared.
        best: with all findings that have a law.
        noise: std of a sample by group of the fit.
        others: `best` solved again without one of its effects, by effect and place.

    Raises:
        InputError: where springs do not hold their sensor, or a simulation does not stay finite.
        NotPositiveDefiniteError: where half of the samples does not hold the motion.
        OutOfTime: where the time of this part of the work is spent.
    """
    if not all(playable(best, h) for h in named(best)):
        return None
    measured = channels(recording)
    judge = Judge(recording, measured, counting(measured, best, recording), noise, parts(best), ((), ()))
    after = learned(best, judge.parts)
    started = [rolled(judge, one, half) for half, one in enumerate(after)]
    first, second = (tuple((w.start, w.end) for w in windows) for windows in started)
    judge = replace(judge, windows=(first, second))
    found = named(best)
    before = learned(declared, judge.parts) if found else after
    with_all = judge.whole(after, started)
    without = judge.whole(before) if found else with_all
    return Beside(
        Simulation(
            "rolled out" if any(judge.windows) else "prescribed",
            judge.judged(),
            all(one.held_out for one in (*before, *after)),
            {c.name: judge.off(c, without[c.name], with_all[c.name]) for c in measured},
        ),
        tuple(judge.compared(c, without, with_all, (*before, *after)) for c in measured),
        {
            key: of
            for h in found
            if (of := of_finding(judge, h, after, with_all, others))
            for key in [(h.effect.name, h.at)]
        },
        unbroken(judge, best, [w for half in started for w in half]),
    )


def parts(fit: Fit) -> tuple[Part, ...]:
    """Return the halves that a recording is cut into, after the free swings of its fit."""
    recording = fit.model.recording
    return parts_of(span_of(recording), recording.free_swings if recording.body is not None else ())


def counting(measured: Sequence[Channel], fit: Fit, recording: Recording) -> dict[str, NDArray[np.bool_]]:
    """Return which samples of every channel are a measurement: not those that clip, are repeated or knocked."""
    stamps, out = fit.model.stamps, {}
    for c in measured:
        mask = (fit.model.masks or {}).get(c.group, np.ones(len(stamps[c.group]), dtype=bool))
        out[c.name] = mask[np.isin(stamps[c.group], c.time)]
    return out


def rolled(judge: Judge, one: Learned, half: int) -> tuple[Swing, ...]:
    """Return the windows of one half that are rolled out: each from its start, or where the last met its horizon."""
    model = sim_model(one.fit)
    if not can_swing(model.rig) or one.fit.model.recording.body is None:
        return ()
    out, misfit = [], judge.misfit(model)
    for swing in free(one.fit):
        for part in (p for p in judge.parts if p.half == half and p.swings):
            start, end = max(part.start, swing[0]), min(part.end, swing[1])
            while end - start >= LEAST_S:
                window = judge.started(one.fit, model, (start, end))
                until = horizon(model.rig, window, misfit)
                out.append(replace(window, end=until if end - until >= LEAST_S else end))
                start = out[-1].end
    return tuple(out)


def unbroken(judge: Judge, fit: Fit, started: Sequence[Swing]) -> tuple[Swing, ...]:
    """Return the windows that a replay rolls out: whole swings, or as they `started` where one met its horizon."""
    if not started:
        return ()
    out, model = [], sim_model(fit)
    ends = [part.end for part in judge.parts if part.swings]
    for swing in free(fit):
        own = [w for w in started if swing[0] <= w.start < swing[1]]
        whole = all(any(np.isclose(w.end, end) for end in (swing[1], *ends)) for w in own)
        out += [judge.started(fit, model, swing)] if whole else own
    return tuple(sorted(out, key=lambda w: w.start))


def of_finding(
    judge: Judge,
    h: Hypothesis,
    after: tuple[Learned, Learned],
    with_all: Mapping[str, Array],
    others: Mapping[tuple[str, str], Fit],
) -> tuple[Comparison, ...]:
    """Return the channels in which an effect matters most, simulated without it and with it."""
    other = others.get((h.effect.name, h.at))
    halves = (without(after[0], h), without(after[1], h)) if other is None else learned(other, judge.parts)
    gone = judge.whole(halves)
    shown = sorted(judge.channels, key=lambda c: -judge.gain(c, gone[c.name], with_all[c.name]))
    return tuple(judge.compared(c, gone, with_all, (*halves, *after)) for c in shown[:MOST])


def without(one: Learned, h: Hypothesis) -> Learned:
    """Return a fit with an effect left out, not solved again: what drives a free swing moves no fit of its sensors."""
    fit = one.fit
    keys = {h.key(p.name) for p in h.effect.parameters}
    fixed = {name: value for name, value in (fit.model.fixed or {}).items() if name not in keys}
    fit = replace(fit, model=replace(fit.model, fixed=fixed))
    return replace(one, fit=extended(fit, tuple(other for other in fit.model.hypotheses if other != h)))


__all__ = ["Beside", "beside"]
