"""The fit of a recording without one of its findings, and by how much that moves what a user asks for.

An effect in the fit is taken out of it and the rest solved again, at the noise levels that the fit has: the motions of
both are compared, and the geometry. What has no name is taken out as the signal that was fitted for it. What the shift
counts for beside what chance does to the same answer is in `estimate_shift`.

An effect that acts on a mount is that mount's error: solved again, what is declared of how well a mount is known would
take its place, and nothing would seem to move. So its geometry is that of the same fit, not solved again, with the
effect left out: the mount as it was declared, up to that. The axis and the joint centre in the sensor's axes are what
its readings tell; where the segment is about the hinge they do not, so the zero of the angle is compared as the others.

What the raw samples show is no part of the fit; it is put back into what the fit sees:

    saturation, dropouts   the samples that were left out count (all of the sensor's that were, but for peaks of knocks)
    impacts                the peaks of the knocks count
    vibration              the readings are those that came, the hum in them
    louder noise           the triple is weighed by its declared noise
    quantisation           y' = y - (step round(m / step) - m), m what the fit reads: the rounding is taken out instead

Nothing is known of what is neither, nor of what drives a free swing: with the sensors in the fit a torque moves
nothing, while a motion that is rolled out by torques alone goes elsewhere.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.discrepancy.terms import Unknown
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import equation_of
from imubench.diagnosis.residual_checks.ordinary_estimates import MOUNT, OrdinaryEstimates
from imubench.diagnosis.result import UNKNOWN, Finding, Move, Pair, is_material
from imubench.diagnosis.samples.check_findings import declared
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART
from imubench.diagnosis.samples.screening import SampleChecks
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import refit_without
from imubench.diagnosis.verdict.estimate_shift import (
    Estimates,
    estimates_of,
    farther_off,
    moves_between,
    spread_of,
    times,
)
from imubench.effects import traits_of
from imubench.effects.traits import Fault
from imubench.recording import Recording


def moves_of(
    findings: Iterable[Finding],
    fit: Fit,
    samples: SampleChecks,
    recording: Recording,
    without: dict[tuple[str, str], Fit] | None = None,
) -> Iterator[tuple[Finding, dict[str, Move]]]:
    """Yield each finding with by how much farther off all is without it, as `shifts_of`.

    Orientations are asked of an orientation filter, mounts beside a measured orientation of the rates.
    """
    ordinary = OrdinaryEstimates.of(fit)
    others = {} if without is None else without
    for finding, shift in shifts_of(findings, fit, samples, recording, others):
        gone = in_fit(fit, finding)
        other = others.get((finding.effect, finding.at)) if gone else None
        yield finding, _farther_off(shift, fit, other, gone, ordinary)


def _farther_off(
    shift: dict[str, Move], fit: Fit, other: Fit | None, gone: list[Hypothesis], ordinary: OrdinaryEstimates | None
) -> dict[str, Move]:
    """Return by how much farther off all is for a shift from one fit to another without the effects that are `gone`.

    Mounts as they are declared are no estimate, and samples that are weighed otherwise are no other model.
    """
    if not shift:
        return shift
    estimated = other is not None and not any(on_mount(h) for h in gone)
    known = farther_off(shift, spread_of(fit), spread_of(other) if other is not None and estimated else None)
    said = ordinary.farther_off(gone) if ordinary is not None and gone else {}
    return known | {name: move for name, move in said.items() if estimated or name != MOUNT}


def shifts_of(
    findings: Iterable[Finding],
    fit: Fit,
    samples: SampleChecks,
    recording: Recording,
    without: dict[tuple[str, str], Fit] | None = None,
) -> Iterator[tuple[Finding, dict[str, Move]]]:
    """Yield each finding with what it shifts, the surest first; nothing where that is not known.

    Args:
        findings: of the fit and of the raw samples, named or not.
        fit: with all that was found.
        samples: what the raw samples say, with their masks.
        recording: as it came.
        without: where the fits without one of those that are in the fit are put, by effect and place.

    Raises:
        OutOfTime: where the part's time is spent; what was yielded stays.
    """
    time = times(fit)
    whole = estimates_of(fit, time)
    for finding in sorted(findings, key=lambda f: -f.confidence):
        other = None
        with suppress(NotPositiveDefiniteError):
            other = fit_without(fit, finding, samples, recording)
        if other is None:
            yield finding, {}
            continue
        gone = in_fit(fit, finding)
        if without is not None and gone:
            without[finding.effect, finding.at] = other
        placed = gone if any(on_mount(h) for h in gone) else []
        yield finding, moves_between(whole, _said_by(other, fit, placed, time), recording)


def with_moves(
    findings: tuple[Finding, ...], moves: Mapping[int, dict[str, Move]], tolerance: Pair
) -> tuple[Finding, ...]:
    """Return findings with what each moves, by its `id`, and whether that is material by the tolerance (deg, mm)."""
    out = []
    for f in findings:
        known = moves.get(id(f), {})
        out.append(replace(f, moves=worth_telling(known, tolerance), material=is_material(known, tolerance)))
    return tuple(out)


def moves_of_all(fit: Fit, recording: Recording, tolerance: Pair) -> dict[str, Move]:
    """Return what everything that was found moves together, as `moves_of` does for one.

    Torques in free swings stay in; empty where nothing is left out, or nothing holds the motion without it.
    """
    gone = [h for h in fit.model.judged if not drives(fit, h)]
    if not gone:
        return {}
    with suppress(NotPositiveDefiniteError):
        time, mounts = times(fit), [h for h in gone if on_mount(h)]
        other = refit_without(fit, gone, SOLVER.refit_steps)
        shift = moves_between(estimates_of(fit, time), _said_by(other, fit, mounts, time), recording)
        ordinary = OrdinaryEstimates.of(fit)
        return worth_telling(_farther_off(shift, fit, other, gone, ordinary), tolerance)
    return {}


def _said_by(other: Fit, fit: Fit, placed: list[Hypothesis], time: Array) -> Estimates:
    """Return what another fit says, its sensors where `fit` has them without the effects in `placed`, if any."""
    said = estimates_of(other, time)
    return said.placed_as(estimates_of(_left_out(fit, placed), time)) if placed else said


def worth_telling(moves: dict[str, Move], tolerance: Pair) -> dict[str, Move]:
    """Return the moves without a constant of the hinge angle that is below the tolerance (deg, mm)."""
    constant = moves.get("hinge_angle_constant")
    if constant is None or constant.beyond(tolerance):
        return moves
    return {name: move for name, move in moves.items() if move is not constant}


def fit_without(fit: Fit, finding: Finding, samples: SampleChecks, recording: Recording) -> Fit | None:
    """Return the fit solved again without a finding; None where that cannot be said."""
    gone = in_fit(fit, finding)
    if gone:
        return None if any(drives(fit, h) for h in gone) else refit_without(fit, gone, SOLVER.refit_steps)
    if not finding.at.startswith("imu"):
        return None
    traits = traits_of(finding.effect)
    if traits.fault is not None and traits.fault.measures_nothing:
        return _counting(fit, finding, samples)
    if traits.tone:
        return _reading(fit, finding.at, {part: getattr(recording.imu(finding.at), part) for part in UNIT_OF_PART})
    if traits.fault is Fault.ROUNDED:
        return _unrounded(fit, finding)
    told = declared(recording.imu(finding.at), traits.channel) if traits.fault is Fault.NOISY else None
    if not told:
        return None
    noise = fit.noise | fit.model.averaging.in_fit({f"{finding.at}.{traits.channel}": told})
    return solve(fit.model, fit.state, noise, fit.anchor, steps=SOLVER.refit_steps)


def in_fit(fit: Fit, finding: Finding) -> list[Hypothesis]:
    """Return what of a fit's model a finding is: its effect at its place, or the terms without a name there."""
    if finding.effect == UNKNOWN:
        return [h for h in fit.model.hypotheses if isinstance(h.effect, Unknown) and h.at == finding.at]
    return [h for h in fit.model.hypotheses if (h.effect.name, h.at) == (finding.effect, finding.at)]


def drives(fit: Fit, h: Hypothesis) -> bool:
    """Return whether an effect enters the equation of motion of a fit's free swings."""
    swings = equation_of(fit.rows) is not None
    return swings and h.effect.drives


def on_mount(h: Hypothesis) -> bool:
    """Return whether an effect moves a sensor on its segment."""
    return h.effect.acts("mount")


def _left_out(fit: Fit, gone: list[Hypothesis]) -> Fit:
    """Return the fit without some effects, not solved again."""
    return extended(fit, tuple(h for h in fit.model.hypotheses if h not in gone))


def _counting(fit: Fit, finding: Finding, samples: SampleChecks) -> Fit:
    """Return the fit with samples counted that a finding of the raw samples left out; the fit where there are none."""
    masks = dict(fit.model.masks or {})
    changed = False
    for part in UNIT_OF_PART:
        name = f"{finding.at}.{part}"
        if name in masks and name in samples.masks:
            peaks = samples.struck.get(finding.at, np.zeros(masks[name].size, dtype=bool))
            struck = traits_of(finding.effect).fault is Fault.STRUCK
            back = peaks if struck else ~samples.masks[name] & ~peaks
            changed |= bool((back & ~masks[name]).any())
            masks[name] = masks[name] | back
    if not changed:
        return fit
    return solve(replace(fit.model, masks=masks), fit.state, fit.noise, fit.anchor, steps=SOLVER.refit_steps)


def _reading(fit: Fit, at: str, readings: Mapping[str, Array]) -> Fit:
    """Return the fit of other readings (n, 3) of one IMU."""
    model: Model = fit.model
    imu = model.recording.imu(at)
    imu = replace(imu, gyro=readings.get("gyro", imu.gyro), accel=readings.get("accel", imu.accel))
    imus = tuple(imu if i.name == at else i for i in model.recording.imus)
    model = replace(model, recording=replace(model.recording, imus=imus))
    return solve(model, fit.state, fit.noise, fit.anchor, steps=SOLVER.refit_steps)


def _unrounded(fit: Fit, finding: Finding) -> Fit | None:
    step = finding.parameters.get("step")
    part = next((part for part, unit in UNIT_OF_PART.items() if step is not None and step.unit == unit), None)
    rows = next((r for r in fit.measured if r.name == f"{finding.at}.{part}"), None)
    if step is None or part is None or rows is None:
        return None
    width = float(step.value)
    counts = (fit.model.masks or {}).get(rows.name, np.ones(len(fit.model.stamps[rows.name]), dtype=bool))
    readings = getattr(fit.model.recording.imu(finding.at), part).copy()
    read = readings[counts] + rows.residual.value
    readings[counts] -= width * np.round(read / width) - read
    return _reading(fit, finding.at, {part: readings})


__all__ = ["drives", "fit_without", "in_fit", "moves_of", "moves_of_all", "shifts_of", "with_moves"]
