"""MuJoCo's simulations beside the recording: the declared model, and the model with all findings.

Both are played twice, once for each half of the recording, with numbers from the other half (`learned`). Inside free
swings they are rolled out by forces alone from the fitted state at the window's start (`rollout`), both over the same
windows; elsewhere the motion that was recovered under the respective model is prescribed, and what is sprung, loose or
late moves by its law.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.simulation import SIMULATED_BESIDE
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.evidence import Comparison, Played, Posed, Swing, Trace
from imubench.diagnosis.noise.noise_levels import levels
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.residual_checks.whole_motion import to_the_ends
from imubench.diagnosis.result import Simulation
from imubench.diagnosis.simulation.channels import Channel, judged_channels
from imubench.diagnosis.simulation.judge import Judge, counting, rolled
from imubench.diagnosis.simulation.learned import Learned, Part, followed, learned, parts_of, with_laws_held
from imubench.diagnosis.simulation.rolled_numbers import halves, of_whole
from imubench.diagnosis.simulation.sim_model import named, playable, sim_model
from imubench.diagnosis.simulation.swing_windows import free
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import refit_without
from imubench.recording import Recording


@dataclass(frozen=True)
class Beside:
    """What MuJoCo says of a recording."""

    simulation: Simulation
    channels: tuple[Comparison, ...]  # every channel: the declared model, and the one with all findings
    findings: Mapping[tuple[str, str], tuple[Comparison, ...]]  # by effect and place: without it, and with it
    windows: tuple[Swing, ...]  # that a replay rolls out, with the states of the whole fit
    added: tuple[Trace, ...] = ()  # by triple of a sensor: what all findings add, of one motion and one start
    motion: Played | None = None  # that a replay prescribes, as smooth as it is estimated; None: that of the fit
    posed: tuple[Posed, ...] = ()  # the declared model, and the one with all findings, or only that one
    numbers: Fit | None = None  # with the numbers that roll-outs of all windows show; None: those of the motion fit


def beside(
    recording: Recording,
    declared: Fit,
    best: Fit,
    noise: Mapping[str, float],
    others: Mapping[tuple[str, str], Fit],
    whole: Recording | None = None,
) -> Beside | None:
    """Return what MuJoCo says of a recording under two models; None where it cannot play what the fit has in it.

    Args:
        recording: as it is held against the models, without what the raw checks took out of it.
        declared: the fit of the model as it was declared.
        best: with all findings that have a law.
        noise: std of a sample, as the recording came, by group of the fit.
        others: `best` solved again without one of its effects, by effect and place.
        whole: the recording as it came, all of which the motion on disk covers; None: `recording`.

    Raises:
        InputError: where springs do not hold their sensor, or a simulation does not stay finite.
        NotPositiveDefiniteError: where half of the samples does not hold the motion.
        OutOfTime: where the time of this part of the work is spent.
    """
    if not all(playable(best, h) for h in named(best)):
        return None
    measured = judged_channels(recording, noise)
    counts = counting(measured, best)
    judge = Judge(recording, measured, counts, noise, parts(best), ((), ()), best.model.averaging)
    found, told = named(best), best
    if found:
        declared, best = as_smooth(as_declared(declared), best)
    after = learned(best, judge.parts)
    of_half = [[part for part in judge.parts if part.half == half] for half in (0, 1)]
    started: Sequence[Sequence[Swing]] = [
        rolled(judge, one.fit, sim_model(one.fit), own) for one, own in zip(after, of_half, strict=True)
    ]
    spans = [tuple((w.start, w.end) for w in windows) for windows in started]
    judge = replace(judge, windows=(spans[0], spans[1]))
    after, started = halves(judge, best, after, started)
    before, begun = halves(judge, declared) if found else (after, started)
    last = judge.whole(after, started)
    first = judge.whole(before, begun) if found else last
    with_all, without = last.channels, first.channels
    fitted, taught = judge.fitted(after), of_whole(judge, best, after, started)
    motion = None if taught is None else fit_summary.played(taught)
    if motion is None and best is not told:
        motion = motion_of(told, best, whole or recording)
    return Beside(
        Simulation(
            "rolled out" if any(judge.windows) else "prescribed",
            judge.judged(),
            all(one.held_out for one in (*before, *after)),
            {c.name: judge.off(c, without[c.name], with_all[c.name], fitted.get(c.name)) for c in measured},
        ),
        tuple(judge.compared(c, without, with_all, (*before, *after)) for c in measured),
        {
            key: of
            for h in found
            if (of := of_finding(judge, h, after, with_all, others))
            for key in [(h.effect.name, h.at)]
        },
        unbroken(judge, best if taught is None else taught, [w for half in started for w in half]),
        added(judge, after, with_all, started) if found else (),
        motion,
        (first.posed, last.posed) if found else (last.posed,),
        taught,
    )


def as_declared(fit: Fit) -> Fit:
    """Return the fit of the declared model without the clocks that a search begins with where they are far off."""
    return refit_without(fit, fit.model.judged) if fit.model.judged else fit


def as_smooth(declared: Fit, best: Fit) -> tuple[Fit, Fit]:
    """Return both fits solved again with one motion's roughness and one noise: as they are estimated beside `best`.

    How rough a hand moves is the hand's. A declared model that lacks a spring is fitted with a motion so rough that it
    rings as the spring does, and every other sensor with it: prescribed to that motion nothing would be wrong with it.
    A search leaves the motion loose as well (`REML.loosened`), so that what it holds smooth is not taken for a
    mismatch.
    """
    rough = [name for name in declared.noise if name.startswith("smooth.")]
    if not rough:
        return declared, best
    best = with_levels(best, {name: best.noise[name] / REML.loosened for name in rough})
    found = levels(best)[0]
    told = {name: found[name] for name in rough}
    measured = {rows.name: best.noise[rows.name] for rows in best.measured}
    levels_of_both = {n: std for n, std in measured.items() if n in declared.noise} | told
    return with_levels(declared, levels_of_both), with_levels(best, told)


def motion_of(told: Fit, smooth: Fit, recording: Recording) -> Played:
    """Return the motion of a fit's own numbers, held as smooth as another fit of the same effects has it.

    From one end of the recording to the other.

    A search's motion is loose, and what is loose in it drives the springs that MuJoCo integrates.
    """
    names = told.model.parameters.widths
    taught = np.concatenate([told.state.values[name] - smooth.state.values[name] for name in names])
    start = followed(smooth, taught)
    held = replace(told.model, fixed=dict(told.state.values))
    found = solve(held, start, with_laws_held(smooth), smooth.anchor, steps=SOLVER.steps)
    return fit_summary.played(to_the_ends(found, recording))


def with_levels(fit: Fit, told: dict[str, float]) -> Fit:
    """Return a fit solved again at other noise levels."""
    return solve(fit.model, fit.state, {**fit.noise, **told}, fit.anchor, steps=SOLVER.few_steps)


def parts(fit: Fit) -> tuple[Part, ...]:
    """Return the halves that a recording is cut into, after the free swings of its fit."""
    recording = fit.model.recording
    return parts_of(recording, recording.free_swings if recording.body is not None else ())


def unbroken(judge: Judge, fit: Fit, started: Sequence[Swing]) -> tuple[Swing, ...]:
    """Return the windows that a replay rolls out: whole swings, or those that `started` where one met its horizon.

    A swing may be declared beyond the samples; a replay ends with them.
    """
    if not started:
        return ()
    out, model = [], sim_model(fit)
    ends = [part.end for part in judge.parts if part.swings]
    first, last = judge.parts[0].start, judge.parts[-1].end
    for swing in ((max(start, first), min(end, last)) for start, end in free(fit)):
        own = [w for w in started if swing[0] <= w.start < swing[1]]
        whole = all(any(np.isclose(w.end, end) for end in (swing[1], *ends)) for w in own)
        out += [judge.started(fit, model, span) for span in ([swing] if whole else [(w.start, w.end) for w in own])]
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
    started: Sequence[Sequence[Swing]]
    if other is None:
        both, started = (without(after[0], (h,)), without(after[1], (h,))), ()
    else:
        both, started = halves(judge, other)
    gone = judge.whole(both, started).channels
    shown = sorted(judge.channels, key=lambda c: -judge.gain(c, gone[c.name], with_all[c.name]))
    return tuple(judge.compared(c, gone, with_all, (*both, *after)) for c in shown[: SIMULATED_BESIDE.channels])


def added(
    judge: Judge, after: tuple[Learned, Learned], with_all: Mapping[str, Array], started: Sequence[Sequence[Swing]]
) -> tuple[Trace, ...]:
    """Return what the effects of a model add to every channel: the model with all of them less the same without any.

    Both have one motion, one set of mounts and one state at the start of every swing, so that what an effect does to
    one sensor does not show in another, as it does in the motion that a declared model is fitted with.

    Args:
        judge: of the recording.
        after: the models with all effects, by half.
        with_all: their channels (n,).
        started: the windows that are rolled out, by half.
    """
    bare = [without(one, one.fit.model.hypotheses) for one in after]
    gone = judge.whole((bare[0], bare[1]), started).channels
    groups: dict[str, list[Channel]] = {}
    for c in judge.channels:
        groups.setdefault(c.group, []).append(c)
    out = []
    for group, channels_of in groups.items():
        own = judge.inside(channels_of[0])
        if own.any():
            at, part = group.split(".")
            values = np.stack([(with_all[c.name] - gone[c.name])[own] for c in channels_of], axis=1)
            first = channels_of[0]
            out.append(
                Trace(
                    at,
                    part,
                    fit_summary.CHANNELS_WITH_UNIT[part][0],
                    first.unit,
                    first.time[own],
                    values,
                    judge.noise[group] * judge.averaging.share(group),
                )
            )
    return tuple(out)


def without(one: Learned, gone: Sequence[Hypothesis]) -> Learned:
    """Return a fit with effects left out, not solved again: what drives a free swing moves no fit of its sensors."""
    fit = one.fit
    keys = {h.key(p.name) for h in gone for p in h.effect.parameters}
    fixed = {name: value for name, value in (fit.model.fixed or {}).items() if name not in keys}
    fit = replace(fit, model=replace(fit.model, fixed=fixed))
    return replace(one, fit=extended(fit, tuple(h for h in fit.model.hypotheses if h not in gone)))


__all__ = ["Beside", "beside"]
