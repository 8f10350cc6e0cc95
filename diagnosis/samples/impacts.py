"""Knocks: the accelerometer above 15 Hz, for tens of milliseconds far above what it is before and after.

Filtered so, a hand's motion is gone (80 dB below 11 Hz) and stationary noise e (n, 3) has |e|^2 / 3 chi-square of
three degrees; over the local level, from as many samples as a second holds, an F ratio. Its quantile at 1e-3 / n
keeps noise out. A motion that starts, stops or turns raises the level on at least one side, a knock on neither.

What a hand does above 15 Hz has a heavy tail: small bumps of handling, in a quick recording by the dozen. If N peaks
that are no knocks exceed four times the level, a tail with any variance at all leaves at most N (4 / r)^2 beyond r
times; a knock lies where that is under 0.05. Several alike may lie nearer, where no smaller peak is beside them. Peaks
below are left out of a fit and not called knocks.
A step or a kink, as where a held limb is let go, is neither.
"""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.samples import HIGH_BAND, IMPACT
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.samples.even_grid import Stretch, smooth_fill
from imubench.diagnosis.samples.high_band import beyond_chance, extended, high, high_pass, peaks_of, quick_power
from imubench.diagnosis.samples.sample_faults import Mask


@dataclass(frozen=True)
class Knocks:
    """When an accelerometer was knocked."""

    times: Array  # (k,) s, where each begins
    ratio: Array  # (k,) amplitude over the local level
    samples: Mask  # (n,) within a knock
    wild: Mask  # (n,) single samples off by more than noise allows


def knocks(
    stretches: tuple[Stretch, ...], rate: float, skip: Mask, step: float, doubted: Mask | None = None
) -> Knocks | None:
    """Return the knocks of a recording; None where it is sampled too slowly.

    Samples of `skip` (n,) begin none, `doubted` ones (n,) only such as are far louder; readings rounded to `step` (0:
    none) are never quieter than the rounding.
    """
    if rate < IMPACT.least_rate_hz:
        return None
    taps = high_pass(rate)
    total = sum(s.time.size for s in stretches)
    limit = max(IMPACT.left_out_power, beyond_chance(total, rate))
    inside, wild = np.zeros(skip.size, dtype=bool), np.zeros(skip.size, dtype=bool)
    times, ratios, whole = [], [], []
    for stretch in (s for s in stretches if s.time.size >= 2 * taps.size):
        power, level, bar = quick_power(stretch, taps, rate, skip, step, doubted)
        for peak in peaks_of(power, IMPACT.tail_ratio**2 * bar, rate):
            if rate >= IMPACT.wild_rate_hz and single(stretch, int(peak), taps, limit * level[peak]):
                wild[stretch.source[peak]] |= power[peak] > limit * bar[peak]
                continue
            if stepped(stretch.accel, int(peak), rate):
                continue
            first = onset(stretch.accel, int(peak), rate)
            times.append(float(stretch.time[first]))
            ratios.append(float(np.sqrt(power[peak] / bar[peak])))
            whole.append(bool(bar[peak] == level[peak]))
            if power[peak] > limit * bar[peak]:
                last = min(int(peak) + round(2 * HIGH_BAND.level_from_s * rate), stretch.time.size)
                loud = np.flatnonzero(power[peak:last] > limit * level[peak:last] / 4)
                inside[stretch.source[first : peak + int(loud[-1]) + 2]] = True
    each = np.array(ratios)
    apart = each > apart_from(each[np.array(whole, dtype=bool)])  # the doubted say nothing of a tail
    return Knocks(np.array(times)[apart], each[apart], inside, wild)


def apart_from(ratios: Array) -> float:
    """Return the ratio beyond which peaks are too many for the tail of the others, or of each other.

    Where all N peaks are beyond r, none lies between: a tail does that with a probability of (4 / r)^2N at most.
    """
    ordered = np.sort(ratios)[::-1]
    if (
        ordered.size
        and ordered[-1] > HIGH_BAND.unsure_factor
        and (IMPACT.tail_ratio / ordered[-1]) ** (2 * ordered.size) < STATISTICS.false_alarms_per_recording
    ):
        return HIGH_BAND.unsure_factor
    knocks = 0  # the largest are; each that is leaves a shorter tail to the others
    while True:
        threshold = IMPACT.tail_ratio * float(np.sqrt(max(1, ordered.size - knocks) / IMPACT.tail_peaks))
        more = int(np.sum(ordered > threshold))
        if more == knocks:
            return threshold
        knocks = more


def single(stretch: Stretch, peak: int, taps: Array, limit: float) -> bool:
    """Return whether one wild sample makes the peak: with it filled in, nothing is left."""
    around = slice(max(0, peak - taps.size), min(stretch.time.size, peak + taps.size + 1))
    piece, one = stretch.accel[around], np.zeros(around.stop - around.start, dtype=bool)
    one[peak - around.start] = True
    left = high(smooth_fill(piece, one), taps)
    near = slice(max(0, peak - around.start - 3), peak - around.start + 4)
    return bool(left[near].max() < limit)


def stepped(accel: Array, peak: int, rate: float) -> bool:
    """Return whether the reading only goes over from one value to another, as where a held limb is let go.

    A knock leaves the straight way between the values before and after it, and by more than these differ; the slope
    that they share is the motion's.
    """
    near, far = max(2, round(IMPACT.change_s * rate)), max(4, round(2 * IMPACT.change_s * rate))
    accel, peak, place = extended(accel, far), peak + far, np.arange(-far, far + 1)
    before, after, between = place <= -near, place >= near, np.abs(place) <= near
    piece = accel[peak + place]
    slope = np.mean([np.polyfit(place[part], piece[part], 1)[0] for part in (before, after)], axis=0)
    piece = piece - slope * place[:, None]
    low = piece[before].mean(axis=0)
    change = piece[after].mean(axis=0) - low
    way = piece[between] - low
    share = np.clip(way @ change / max(float(change @ change), 1e-12), 0, 1)
    off = np.linalg.norm(way - share[:, None] * change, axis=1)
    return bool(off.max() < IMPACT.change_share * np.linalg.norm(change))


def onset(accel: Array, peak: int, rate: float) -> int:
    """Return the sample at which a knock begins: where second differences first rise to a share of their largest."""
    start = max(1, peak - max(2, round(0.05 * rate)))
    stop = min(len(accel) - 1, peak + max(2, round(0.02 * rate)))
    bend = np.linalg.norm(np.diff(accel[start - 1 : stop + 1], 2, axis=0), axis=1)
    return start + int(np.argmax(bend > IMPACT.onset_share * bend.max()))
