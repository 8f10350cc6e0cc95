"""A recording that simulations are held against: where they are rolled out, from which states, how far they are off."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.budget import check
from imubench.diagnosis.config.correction import REPLAY
from imubench.diagnosis.config.simulation import ROLL_OUT, SIMULATED_BESIDE
from imubench.diagnosis.evidence import Comparison, Posed, Swing
from imubench.diagnosis.problem.averaging import AS_RECORDED, Averaging
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.result import SimulatedChannel
from imubench.diagnosis.simulation.channels import Channel, Simulated, channels, dense_rate, read_out, simulated
from imubench.diagnosis.simulation.learned import Learned, Part, half_at
from imubench.diagnosis.simulation.roll_outs import RollOuts
from imubench.diagnosis.simulation.rollout import Misfit, can_swing, horizon, refined
from imubench.diagnosis.simulation.sim_model import SimModel, sim_model, state_at
from imubench.diagnosis.simulation.swing_windows import free
from imubench.diagnosis.solve.subset import cut
from imubench.diagnosis.windows import Window, covered
from imubench.recording import Recording


@dataclass(frozen=True)
class Judge:
    """A recording, and where and how models are held against it."""

    recording: Recording
    channels: tuple[Channel, ...]
    counts: Mapping[str, NDArray[np.bool_]]  # by channel: samples (n,) that are a measurement
    noise: Mapping[str, float]  # std by group
    parts: tuple[Part, ...]
    windows: tuple[tuple[Window, ...], tuple[Window, ...]]  # that are rolled out, by half
    averaging: Averaging = AS_RECORDED  # of the samples, where they are fewer than those whose `noise` it is
    foretells: bool = False  # whether a hinge's windows begin as their first second shows, and the rest is foretold
    roll_outs: RollOuts = field(
        default_factory=lambda: RollOuts(SIMULATED_BESIDE.start_rate_hz, SIMULATED_BESIDE.start_step_s)
    )  # while starts and numbers are looked for

    def misfit(self, model: SimModel) -> Misfit:
        """Return a function of a window: its samples' times, and simulated minus measured over the noise."""
        known: dict[Window, tuple[Recording, list[tuple[Channel, NDArray[np.bool_]]]]] = {}

        def of(swing: Swing) -> tuple[Array, Array]:
            check()
            key = swing.start, swing.end
            if key not in known:
                known[key] = self.samples(swing.start, swing.end)
            recording, own = known[key]
            truth = self.roll_outs.truth(model, swing, angle_alone=not (recording.imus or recording.poses))
            read = read_out(model, recording, truth, swing.start)
            times = [c.time[counts] for c, counts in own]
            off = [(read[c.name] - c.measured)[counts] / self.noise[c.group] for c, counts in own]
            return np.concatenate(times), np.concatenate(off)

        return of

    def samples(self, start: float, end: float) -> tuple[Recording, list[tuple[Channel, NDArray[np.bool_]]]]:
        """Return the recording between two times in s, its channels, and which of their samples (n,) count there."""
        margin = REPLAY.end_rows / SIMULATED_BESIDE.start_rate_hz
        low, high = start + margin, end - margin
        counts = {c.name: self.counts[c.name][(c.time >= low) & (c.time <= high)] for c in self.channels}
        inside = [int(mask.size) for mask in counts.values()]
        if min(inside) > 1:
            part = cut(self.recording, low, high)
            return part, [(c, counts[c.name]) for c in channels(part) if c.name in counts]
        whole = [(c, self.counts[c.name] & (c.time >= low) & (c.time <= high)) for c in self.channels]
        return self.recording, whole

    def played(self, one: Learned, half: int, started: Sequence[Swing] | None = None) -> Simulated:
        """Return the recording as one half's model plays it, from the states in `started` where they are known."""
        check()
        model = sim_model(one.fit)
        if started is None:
            started = self.begins(one, half)
        return simulated(model, self.recording, tuple(started))

    def begins(self, one: Learned, half: int) -> tuple[Swing, ...]:
        """Return the windows of a half with the states at their starts that fit best with one model's numbers."""
        model = sim_model(one.fit)
        return tuple(self.started(one.fit, model, span) for span in self.windows[half])

    def begun(self, fit: Fit, model: SimModel, span: Window) -> Swing:
        """Return a window with the state at its start that its first second shows."""
        return refined(model.rig, Swing(*span, state_at(fit, span[0])), self.misfit(model))

    def started(self, fit: Fit, model: SimModel, span: Window) -> Swing:
        """Return a window that ends by its horizon with the state at its start that fits all of it best.

        That of its first second, where a hinge's other seconds are foretold.
        """
        begun = self.begun(fit, model, span)
        if self.foretells and model.rig.tree.hinge is not None:
            return begun
        return refined(model.rig, begun, self.misfit(model), span[1] - span[0])

    def whole(self, halves: tuple[Learned, Learned], started: Sequence[Sequence[Swing]] = ()) -> Simulated:
        """Return the recording, each half of it as it is played for that."""
        known = started if any(started) else (None, None)
        first, second = (self.played(one, half, known[half]) for half, one in enumerate(halves))
        read = {
            c.name: np.where(half_at(self.parts, c.time) == 0, first.channels[c.name], second.channels[c.name])
            for c in self.channels
        }
        return Simulated(read, self.joined(first.posed, second.posed))

    def joined(self, first: Posed, second: Posed) -> Posed:
        """Return where two simulations have the rig, each in the half of the recording that it is played for."""
        own = [half_at(self.parts, one.time) == half for half, one in enumerate((first, second))]
        time = np.concatenate([first.time[own[0]], second.time[own[1]]])
        order = np.argsort(time)

        def both(a: Mapping[str, tuple[Array, Array]], b: Mapping[str, tuple[Array, Array]]) -> dict[str, Any]:
            return {
                name: tuple(
                    np.concatenate([x[own[0]], y[own[1]]])[order] for x, y in zip(a[name], b[name], strict=True)
                )
                for name in a
            }

        return Posed(time[order], both(first.segments, second.segments), both(first.sensors, second.sensors))

    def judged(self) -> tuple[Window, ...]:
        """Return the windows that are judged: those that are rolled out, or everything where none is."""
        rolled = tuple(sorted(span for half in self.windows for span in half))
        return rolled or ((self.parts[0].start, self.parts[-1].end),)

    def inside(self, channel: Channel) -> NDArray[np.bool_]:
        """Return which samples (n,) of a channel are judged."""
        margin = REPLAY.end_rows / dense_rate(self.recording) if any(self.windows) else 0.0
        windows = [(start + margin, end - margin) for start, end in self.judged()]
        return self.counts[channel.name] & covered(channel.time, windows)

    def off(self, channel: Channel, before: Array, after: Array, fit: Array | None = None) -> SimulatedChannel:
        """Return how far two simulations (n,) are from a channel, and what a motion `fit` (n,) itself reads.

        Of averaged samples with the noise that averaging took, which is white and in no simulation.
        """
        own = self.inside(channel)
        taken = self.noise[channel.group] ** 2 * (1 - self.averaging.share(channel.group) ** 2)

        def rms(read: Array) -> float:
            return float(np.sqrt(np.mean((read - channel.measured)[own] ** 2) + taken)) if own.any() else 0.0

        told = None if fit is None else rms(fit)
        return SimulatedChannel(channel.unit, rms(before), rms(after), self.noise[channel.group], told)

    def fitted(self, halves: tuple[Learned, Learned]) -> dict[str, Array]:
        """Return the channels as the motion fits read them, each half of the recording by the fit that judges it.

        Samples that do not count are as measured. A pose whose errors last has no such channel: its rows are not its
        readings.
        """
        rows = [{r.name: r.residual.value for r in one.fit.measured} for one in halves]
        wanders = halves[0].fit.model.wander
        out: dict[str, Array] = {}
        column: dict[str, int] = {}
        for c in self.channels:
            k = column[c.group] = column.get(c.group, -1) + 1
            if not all(c.group in own for own in rows) or c.group.partition(".")[0] in wanders:
                continue
            counts, both = self.counts[c.name], []
            for own in rows:
                both.append(np.array(c.measured))
                both[-1][counts] += own[c.group][:, k]
            out[c.name] = np.where(half_at(self.parts, c.time) == 0, *both)
        return out

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
        noise = self.noise[channel.group] * self.averaging.share(channel.group)
        return Comparison(channel.name, channel.unit, channel.time, *values, noise, span if told else ())


def rolled(
    judge: Judge, fit: Fit, model: SimModel, parts: Iterable[Part], friction: float | None = None
) -> tuple[Swing, ...]:
    """Return the windows of some parts that are rolled out: each from its start, or where the last met its horizon.

    Args:
        judge: of the recording.
        fit: whose motion says where the windows start, and when a hand holds the body.
        model: that is rolled out.
        parts: of the recording.
        friction: N m, dry friction that may hold the body; None: the fit's.
    """
    if not can_swing(model.rig) or fit.model.recording.body is None:
        return ()
    out, misfit = [], judge.misfit(model)
    for swing in free(fit, friction):
        for part in (p for p in parts if p.swings):
            start, end = max(part.start, swing[0]), min(part.end, swing[1])
            while end - start >= ROLL_OUT.least_s:
                until = horizon(model.rig, judge.begun(fit, model, (start, end)), misfit)
                out.append(judge.started(fit, model, (start, cut_by(until, start, end))))
                start = out[-1].end
    return tuple(out)


def cut_by(horizon: float, start: float, end: float) -> float:
    """Return where a window that may last from `start` to `end`, s, is cut: by its horizon, leaving no remnant."""
    cut = min(horizon, end - ROLL_OUT.least_s)
    return end if horizon >= end or cut - start < ROLL_OUT.least_s else cut


def counting(measured: Sequence[Channel], fit: Fit) -> dict[str, NDArray[np.bool_]]:
    """Return which samples of every channel are a measurement: not those that clip, are repeated or knocked."""
    stamps, out = fit.model.stamps, {}
    for c in measured:
        mask = (fit.model.masks or {}).get(c.group, np.ones(len(stamps[c.group]), dtype=bool))
        out[c.name] = mask[np.isin(stamps[c.group], c.time)]
    return out


__all__ = ["Judge", "counting", "rolled"]
