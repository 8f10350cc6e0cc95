"""What single samples say about a sensor: clipped, rounded, repeated or lost, read off the values themselves."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label
from scipy.special import erf

from imubench.arrays import Array
from imubench.diagnosis.config.samples import DROPOUT, LATTICE
from imubench.diagnosis.config.shared import DECLARED_NOISE, STATISTICS
from imubench.diagnosis.config.solve import ALGEBRA

Mask = np.ndarray[tuple[int], np.dtype[np.bool_]]
UNIT_OF_PART = {"gyro": "rad/s", "accel": "m/s^2"}
"""The triples of an IMU, with the units that they are in."""

# (a rounded parabola falls 3 steps over half a plateau's length, a fourth power 15)


@dataclass(frozen=True)
class Lost:
    """Samples that are not there, or say the last one again."""

    held: Mask  # (n,) repeats of the sample before
    fraction_held: float
    fraction_missing: float
    events_held: int
    events_missing: int
    pairs: int  # of neighbours that could have shown a repeat
    after: Array  # (m,) s, stamps behind a gap


def lattice(values: Array) -> float:
    """Return the step on which values (n,) lie, 0 where there is none or too few values tell.

    The step is the median gap between different values, or a simple fraction of it where a short recording of a wide
    motion skips most steps, if all gaps are its multiples. A finer one (digits of a text file) comes out as 0.
    """
    spread = float(np.ptp(values))
    if spread == 0:
        return 0.0
    gaps = np.diff(np.unique(values))
    gaps = gaps[gaps > ALGEBRA.half_digits * spread]
    if gaps.size < LATTICE.gaps and values.size < LATTICE.repeats * (gaps.size + 1):
        return 0.0
    tried = (_multiples(gaps, float(np.median(gaps)) / part) for part in range(1, LATTICE.skipped_steps + 1))
    return next((step for step in tried if step > 0), 0.0)


def _multiples(gaps: Array, step: float) -> float:
    """Return the step near `step` of which all gaps (n,) are multiples, 0 where they are not."""
    for _ in range(3):
        count = np.round(gaps / step)
        good = count > 0
        step = float(np.sum(gaps[good]) / np.sum(count[good]))
    fits = np.abs(gaps / step - np.round(gaps / step)) < LATTICE.off_lattice
    return step if np.mean(fits & (gaps > 0.5 * step)) > 0.98 else 0.0


def steps(values: Array) -> Array:
    """Return the step (3,) of each axis, 0 for none; an axis with too few values takes another's."""
    out = np.array([lattice(v) for v in values.T])
    if out.any():
        for axis in np.flatnonzero(out == 0):
            if np.unique(values[:, axis]).size <= LATTICE.gaps:
                out[axis] = np.median(out[out > 0])
    return out


def lost(time: Array, channels: Array, step: Array) -> Lost:
    """Return the repeated and missing samples of channels (n, k) with their steps (k,), 0 for continuous.

    A repeat is a sample equal to the one before in every channel. Where all channels are rounded it counts only
    if its neighbours differ by three steps in one of them, so a sensor at rest holds nothing.
    """
    interval = np.diff(time)
    usual = float(np.median(interval))
    counts = np.round(interval / usual)
    jitter = 1.4826 * float(np.median(np.abs(interval / usual - 1)))
    gap = (counts >= 2) & (jitter < DROPOUT.jitter)
    odd = missing_in_a_row(counts[gap] - 1, time.size)
    missing = int(odd.sum())

    held = np.zeros(time.size, dtype=bool)
    could = np.zeros(time.size, dtype=bool)
    same = (channels[1:] == channels[:-1]).all(axis=1)
    if np.any((step == 0) & (np.ptp(channels, axis=0) > 0)):
        could[1:] = True
    else:
        # behind a run of repeats, the next other sample says whether the sensor moved meanwhile
        other = np.append(np.flatnonzero(~same) + 1, time.size - 1)
        following = other[np.searchsorted(other, np.arange(1, time.size), side="right").clip(max=other.size - 1)]
        move = np.abs(channels[following] - channels[:-1]) / np.where(step > 0, step, np.inf)
        could[1:] = (move > DROPOUT.moving_steps).any(axis=1)
    held[1:] = same & could[1:]
    pieces, count = label(held)
    length = np.bincount(pieces.ravel(), minlength=count + 1)
    short = held & (
        length[pieces] <= max(DROPOUT.run_samples, round(DROPOUT.run_s / usual))
    )  # longer: stuck, or a rest without noise
    pairs = int(could.sum() - (held & ~short).sum())
    return Lost(
        held,
        float(short.sum() / pairs) if pairs > 0 else 0.0,
        missing / (time.size + missing),
        int(np.sum(short[1:] & ~short[:-1])),
        odd.size,
        pairs,
        time[1:][gap],
    )


def missing_in_a_row(runs: Array, count: int) -> Array:
    """Return how many samples are missing in a row (k,), of `count`, without runs too long for single ones to be lost.

    A share f of samples lost one by one has count f^k runs of k: one of which there would be no more than
    `STATISTICS.false_alarms_per_recording` is a gap.
    """
    while runs.size:
        share = float(runs.sum() / (count + runs.sum()))
        short = runs <= np.ceil(np.log(STATISTICS.false_alarms_per_recording / count) / np.log(share))
        if short.all():
            break
        runs = runs[short]
    return runs


def more_than_odd(events: int, count: int) -> bool:
    """Return whether so many gaps or repeats in `count` samples are more than the odd one."""
    return events >= max(DROPOUT.events, DROPOUT.share * count)


def clipped(time: Array, values: Array, step: Array, noise: float, skip: Mask, still: Mask) -> tuple[Mask, Array]:
    """Return which of values (n, 3) are at a limit (n,), and the limits of the axes and sides that clip (k,).

    `step` (3,), `noise` its std per sample; `skip`: repeats, `still`: at rest, neither counts.
    """
    at = np.zeros(values.shape, dtype=bool)
    limits = []
    for axis in range(values.shape[1]):
        for side in (1.0, -1.0):
            x = side * values[:, axis]
            top = float(x.max())
            here = (
                x >= top - 1e-6 * abs(top) - 0.5 * (step[axis] if step[axis] > LATTICE.fine_step * noise else 0)
            ) & ~skip
            if (
                top > 0
                and here.sum() >= LATTICE.plateau_samples
                and _sure(time, x, here & ~still, float(step[axis]), noise)
            ):
                at[:, axis] |= here
                limits.append(top)
    if not limits:
        return np.zeros(len(values), dtype=bool), np.array([])
    low = np.median(limits)  # of clips at one limit, what another axis only reaches once is clipped too
    at |= (np.abs(np.abs(values) - low) < 1e-6 * low) & (np.abs(values) >= low * (1 - 1e-6))
    return np.asarray(at.any(axis=1)), np.array(limits, dtype=float)


def _sure(time: Array, x: Array, here: Mask, step: float, noise: float) -> bool:
    """Return whether x (n,) ends at its largest value.

    If continuous, no three readings are equal by chance. If rounded, either a plateau is longer than noise lets a
    reading stay in one step (0.8 of the noise, as its level may be off), or readings fall off fast on both sides.
    """
    if step <= LATTICE.fine_step * noise:
        return bool(here.sum() >= LATTICE.plateau_samples)
    reach = max(1, round(LATTICE.drop_s / float(np.median(np.diff(time)))))
    plateaus, count = label(here)
    stay = float(erf(step / (2 * np.sqrt(2) * max(DECLARED_NOISE.least_std * noise, 1e-12))))
    if np.bincount(plateaus)[1:].max(initial=0) > np.log(x.size / STATISTICS.false_alarm_of_one) / max(
        -np.log(stay), 1e-12
    ):
        return True
    kinks = 0
    for i in range(1, count + 1):
        inside = np.flatnonzero(plateaus == i)
        first, last = int(inside[0]), int(inside[-1])
        out = min(reach, max(1, (last - first + 2) // 2))
        if first < out or last + out >= x.size:
            continue
        top = x[first]
        fall = min(top - x[first - out], top - x[last + out])
        kinks += int(last - first + 1) if last > first and fall > LATTICE.drop_steps * step + 5 * noise else 0
    return kinks >= LATTICE.plateau_samples
