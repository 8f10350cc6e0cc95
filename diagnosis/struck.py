"""Knocks that the raw samples doubt, held against the fit.

Peaks that a quick hand may have made are left out of the fit and not called knocks. What moves segment and sensor
together the fit explains: with a peak's n numbers among its samples its cost rises by about n / 2 less what the motion
takes of them. A knock is in one sensor, and no motion. So the fit is solved with the peaks in it, and with as many
stretches of other samples left out; Q = 2 (cost with - cost without) / n is the power per number that no motion
explains, summed over every row within `BESIDE` of a peak. Peaks beyond chance are knocks where none of the other
stretches is beyond it: a real hand's peaks have Q of 10 and 30 beside others of 3, and are no knocks. Nor are those of
a swing that turns round beside dry friction.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from imubench.arrays import Array
from imubench.diagnosis.fit import AGAIN, Fit, solve
from imubench.diagnosis.prune import SEED
from imubench.diagnosis.raw_findings import SURE_OF_KNOCKS, joined
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.diagnosis.swings import turning
from imubench.diagnosis.verdict import KNOCKING

Mask = NDArray[np.bool_]
Window = tuple[float, float]

DRY = "dry_friction"
INSIDE = 9  # moments of a stretch that are looked at
BESIDE = 0.25  # s on either side of a peak, in which the fit bends for it
TOGETHER = 0.1  # s: nearer peaks are one
FEWEST = 2  # samples of a peak; a single wild one is none
OTHERS, FEWEST_OTHERS = 20, 5  # stretches of other samples
ALARM = 1e-6  # of each peak, of noise alone
OTHERS_ALARM = 1e-4  # of each of the others: beyond, the fit leaves more than noise, and a peak may be that


def struck_again(fit: Fit, struck: Mapping[str, Mask], named: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return knocks among the peaks `struck` ("imu1" -> (n,) samples) that the fit has not seen and cannot explain.

    Not where `named` has what knocks by itself, nor at an IMU of which the raw samples told some.
    """
    if any(f.effect in KNOCKING for f in named):
        return ()
    told = {f.at for f in named if f.effect == "impacts"}
    out = []
    for imu in (i for i in fit.model.recording.imus if i.name in struck and i.name not in told):
        peaks = joined(imu.time[struck[imu.name]], TOGETHER, FEWEST)
        if any(f.effect == DRY for f in named):
            peaks = tuple(p for p in peaks if not turns_round(fit, p))
        peaks = tuple(p for p in peaks if not slips(fit, imu.name, p))
        times = knocks(fit, imu.name, struck[imu.name], peaks) if peaks else np.array([])
        if times.size:
            parameters = {"times": Parameter(times, np.full(times.size, 1 / imu.rate), "s")}
            sure = SURE_OF_KNOCKS[times.size > 1]
            out.append(Finding("impacts", imu.name, sure, parameters, Interval(0.0, (0.0, 0.0))))
    return tuple(out)


def turns_round(fit: Fit, window: Window) -> bool:
    """Return whether a swing turns round in a stretch (s): dry friction jumps there, and no spline follows a jump."""
    body, (start, end) = fit.model.recording.body, window
    if body is None or not any(a <= end and b >= start for a, b in fit.model.recording.free_swings):
        return False
    return bool(turning(fit.model, body, np.linspace(start, end, INSIDE) - fit.model.start).any())


def slips(fit: Fit, imu: str, window: Window) -> bool:
    """Return whether a stretch (s) is where an effect of the fit acts as its law does not say, as a mount that slips.

    Beside it too: it is where a peak begins that such a moment is known by.
    """
    start, end = (t - fit.model.start for t in window)
    windows = [w for h in fit.model.at(imu) for w in fit.model.blind(h, fit.state)]
    return any(a - BESIDE <= end and b + BESIDE >= start for a, b in windows)


def knocks(fit: Fit, imu: str, struck: Mask, peaks: Sequence[Window]) -> Array:
    """Return when the peaks (s) that no motion explains begin."""
    time = fit.model.recording.imu(imu).time
    known = dict(fit.model.masks or {})
    names = [name for name in known if name.startswith(f"{imu}.")]
    others = elsewhere(time, np.logical_and.reduce([known[name] for name in names]), peaks)
    if len(others) < FEWEST_OTHERS:
        return np.array([])
    left_out = ~np.any([(time >= a) & (time <= b) for a, b in others], axis=0)
    without = solved(fit, {name: known[name] & left_out for name in names})
    if any(power > chance(OTHERS_ALARM, n) for power, n in (unexplained(without, fit, p) for p in others)):
        return np.array([])
    with_peaks = solved(fit, {name: known[name] | struck for name in names})
    found = [unexplained(fit, with_peaks, p) for p in peaks]
    return np.array([a for (a, _), (power, n) in zip(peaks, found, strict=True) if power > chance(ALARM, n)])


def chance(alarm: float, count: float) -> float:
    """Return the Q that noise exceeds with a probability of `alarm`, of so many numbers."""
    return float(chi2.isf(alarm, count) / count)


def solved(fit: Fit, masks: Mapping[str, Mask]) -> Fit:
    """Return the fit on other samples, noise levels as they are."""
    model = replace(fit.model, masks={**(fit.model.masks or {}), **masks})
    return solve(model, fit.state, fit.noise, fit.anchor, steps=AGAIN)


def unexplained(without: Fit, with_it: Fit, window: Window) -> tuple[float, float]:
    """Return Q of a stretch (s) that one fit has and the other has not, and how many numbers are in it."""
    (few, less), (many, more) = (within(fit, window) for fit in (without, with_it))
    count = max(many - few, 1)
    return 2 * (more - less) / count, float(count)


def within(fit: Fit, window: Window) -> tuple[int, float]:
    """Return how many measured numbers are near a stretch (s), and the cost of all rows there."""
    start, end = (t - fit.model.start for t in window)
    count, cost = 0, 0.0
    for rows in fit.rows:
        near = (rows.time >= start - BESIDE) & (rows.time <= end + BESIDE)
        if len(rows.time) == len(rows.residual.value) and near.any():
            cost += 0.5 * float(np.sum(rows.whitened.reshape(len(near), -1)[near] ** 2))
            count += int(near.sum()) * rows.residual.value.shape[1] if rows.counts else 0
    return count, cost


def elsewhere(time: Array, counts: Mask, peaks: Sequence[Window]) -> list[Window]:
    """Return stretches as long as the peaks, at random, of samples that count (n,) and lie apart."""
    rng = np.random.default_rng(SEED)
    lengths = [b - a for a, b in peaks]
    out: list[Window] = []
    for _ in range(10 * OTHERS):
        start = float(rng.uniform(time[0] + 2 * BESIDE, time[-1] - 2 * BESIDE))
        window = (start, start + float(rng.choice(lengths)))
        inside = (time >= window[0] - BESIDE) & (time <= window[1] + BESIDE)
        apart = all(abs(start - a) > 4 * BESIDE for a, _ in out)
        if counts[inside].all() and apart and len(out) < OTHERS:
            out.append(window)
    return out


__all__ = ["struck_again"]
