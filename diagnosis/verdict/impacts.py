"""Knocks that the raw samples doubt, held against the fit.

Peaks that a quick hand may have made are left out of the fit and not called knocks. What moves segment and sensor
together the fit explains; a knock is in one sensor, and no motion. So the fit is solved with the peaks in it, and with
as many stretches of other samples left out (`unmoved`). Peaks beyond chance are knocks where none of the other
stretches is beyond it: a real hand's peaks have a Q of 10 and 30 beside others of 3, and are no knocks. Nor are those
of a swing that turns round beside dry friction. Several too faint to be left out are held against the fit together.
"""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import IMPACT_TEST
from imubench.diagnosis.config.samples import HIGH_BAND
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.config.verdict import KNOCK
from imubench.diagnosis.criteria.impact_test import counted, knocks, solved
from imubench.diagnosis.noise.looser_motion import at_estimated_roughness
from imubench.diagnosis.problem.dynamics_factors import turning
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.diagnosis.samples.check_findings import called, confidence_of_knocks, joined
from imubench.diagnosis.samples.faint_impacts import faint_knocks
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART
from imubench.diagnosis.search.confidence import DOUBTFUL
from imubench.diagnosis.windows import Window, covered
from imubench.effects import traits_of
from imubench.effects.traits import Fault
from imubench.recording import Imu

Mask = NDArray[np.bool_]


def unseen_knocks(
    fit: Fit, struck: Mapping[str, Mask], named: Sequence[Finding], sprung: Collection[str] = ()
) -> tuple[Finding, ...]:
    """Return knocks among the peaks `struck` ("imu1" -> (n,) samples) that the fit has not seen and cannot explain.

    Not where `named` has what knocks by itself, nor at an IMU of which the raw samples told some. Doubted where springs
    (`sprung`, of IMUs) explained much and foretold nothing: a mount that rings after a push does so in one sensor too.
    """
    if any(traits_of(f.effect).knocks for f in named):
        return ()
    told = {f.at for f in named if traits_of(f.effect).fault is Fault.STRUCK}
    out = []
    for imu in (i for i in fit.model.recording.imus if i.name not in told):
        samples = struck.get(imu.name, np.zeros(imu.time.size, dtype=bool))
        peaks = joined(imu.time[samples], HIGH_BAND.one_knock_s, EVIDENCE.events)
        if any(traits_of(f.effect).holds_by for f in named):
            peaks = tuple(p for p in peaks if not turns_round(fit, p))
        peaks = tuple(p for p in peaks if not slips(fit, imu.name, p))
        times = knocks(fit, imu.name, samples, peaks) if peaks else np.array([])
        if not times.size:
            times = faint(fit, imu, samples, named)
        if times.size:
            parameters = {"times": Parameter(times, np.full(times.size, 1 / imu.rate), "s")}
            sure = min(confidence_of_knocks(times), DOUBTFUL if imu.name in sprung else 1.0)
            out.append(Finding(called(Fault.STRUCK), imu.name, sure, parameters, Interval(0.0, (0.0, 0.0))))
    return tuple(out)


def faint(fit: Fit, imu: Imu, struck: Mask, named: Sequence[Finding]) -> Array:
    """Return when knocks (s) begin that are too faint for the raw samples; none where samples are lost or swing freely.

    What a gap is filled with is no sample, and the equation of a swing does not know what may hold a segment up. Beside
    a pose whose errors wander nobody knows an IMU's noise: a phone's quick turns had peaks that no motion explained.
    Nothing but an IMU itself tells how a lone body is pushed, and a free motion follows its knocks. So that is held as
    smooth as it is elsewhere: peaks are 4 to 12 times the noise then, other stretches 0.4 to 1.0, and a hand's strokes
    are too much for the others as well.
    """
    unsure = fit.model.wander or fit.model.recording.body is not None
    faults = [(f, traits_of(f.effect).fault) for f in named if f.at == imu.name]
    if unsure or any(fault is Fault.LOST for _, fault in faults):
        return np.array([])
    known = counted(fit, imu.name)
    steps = [f.parameters["step"] for f, fault in faults if fault is Fault.ROUNDED]
    step = max([0.0, *(float(s.value) for s in steps if s.unit == UNIT_OF_PART["accel"])])
    peaks = faint_knocks(imu, ~(np.logical_and.reduce([*known.values()]) | struck), step)
    peaks = tuple(p for p in peaks if not slips(fit, imu.name, p))
    if len(peaks) < EVIDENCE.events:
        return np.array([])
    if fit.model.rig.placed and len(fit.model.recording.imus) == 1:
        fit = solved(at_estimated_roughness(fit), {})
    inside = covered(imu.time, peaks)
    pushed = f"{imu.name}.accel"  # what is struck reads a force
    apart = solved(fit, {pushed: known[pushed] & ~inside})
    return knocks(apart, imu.name, inside, peaks, together=True)


def turns_round(fit: Fit, window: Window) -> bool:
    """Return whether a swing turns round in a stretch (s): dry friction jumps there, and no spline follows a jump."""
    body, (start, end) = fit.model.recording.body, window
    if body is None or not any(a <= end and b >= start for a, b in fit.model.recording.free_swings):
        return False
    return bool(turning(fit.model, body, np.linspace(start, end, KNOCK.moments) - fit.model.start).any())


def slips(fit: Fit, imu: str, window: Window) -> bool:
    """Return whether a stretch (s) is where an effect of the fit acts as its law does not say, as a mount that slips.

    Beside it too: it is where a peak begins that such a moment is known by.
    """
    start, end = (t - fit.model.start for t in window)
    windows = [w for h in fit.model.at(imu) for w in fit.model.blind(h, fit.state)]
    return any(a - IMPACT_TEST.beside_s <= end and b + IMPACT_TEST.beside_s >= start for a, b in windows)


__all__ = ["unseen_knocks"]
