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
from scipy.ndimage import median_filter
from scipy.signal import fftconvolve, find_peaks, firwin
from scipy.stats import chi2
from scipy.stats import f as f_ratio

from imubench.arrays import Array
from imubench.diagnosis.raw_grid import Stretch, smooth_fill
from imubench.diagnosis.raw_samples import Mask

CUT, SLOPE, BETA = 15.0, 8.0, 7.86  # Hz, Hz from stop to pass, of the Kaiser window for 80 dB
LENGTH = 0.627  # s, that window's
SLOWEST = 45.0  # Hz, a rate under which too little is left above 19 Hz
NEAR, FAR = 0.15, 1.0  # s, from a peak: the local level is taken between them, on either side
ALARM = 1e-3  # per recording, of stationary noise
STEADY = 36.0  # of power: six times in amplitude, from which a peak is left out of a fit
HEAVY, BEYOND = 4.0, 0.05  # ratio of amplitude from which a tail is counted, number allowed beyond a knock's
FAR_OFF = 2.5  # times that ratio, from which on peaks without a tail are looked at
TOGETHER, ECHO, FAINT = 0.2, 0.35, 0.1  # s, s, of the amplitude: nearer peaks are one knock, fainter ones its echo
FAST = 80.0  # Hz, a rate from which a knock spans samples and a single wild one is none
OVER, ASTRAY = 0.05, 0.35  # s, a change takes no longer on either side of a peak; of it, how far it strays
ONSET = 0.15  # of the peak, where a knock begins

Peaks = np.ndarray[tuple[int], np.dtype[np.int64]]


@dataclass(frozen=True)
class Knocks:
    """When an accelerometer was knocked."""

    times: Array  # (k,) s, where each begins
    ratio: Array  # (k,) amplitude over the local level
    samples: Mask  # (n,) within a knock
    wild: Mask  # (n,) single samples off by more than noise allows


def knocks(stretches: tuple[Stretch, ...], rate: float, skip: Mask, step: float) -> Knocks | None:
    """Return the knocks of a recording; None where it is sampled too slowly.

    Samples of `skip` (n,) begin none; readings rounded to `step` (0: none) are never quieter than the rounding.
    """
    if rate < SLOWEST:
        return None
    size = int(LENGTH * rate) | 1
    taps = firwin(size, CUT, pass_zero=False, window=("kaiser", BETA), fs=rate)
    total = sum(s.time.size for s in stretches)
    limit = max(STEADY, beyond_chance(total, rate))
    inside, wild = np.zeros(skip.size, dtype=bool), np.zeros(skip.size, dtype=bool)
    times, ratios = [], []
    for stretch in stretches:
        if stretch.time.size < 2 * size:
            continue
        power = high(stretch.accel, taps)
        level = np.maximum(local_level(power, rate), step**2 / 12)
        power[: size // 2], power[-(size // 2) :] = 0.0, 0.0
        power[skip[stretch.source]] = 0.0
        peaks, _ = find_peaks(power, height=HEAVY**2 * level, distance=max(1, round(TOGETHER * rate)))
        for peak in alone(peaks, power, rate):
            if rate >= FAST and single(stretch, int(peak), taps, limit * level[peak], size):
                wild[stretch.source[peak]] |= power[peak] > limit * level[peak]
                continue
            if stepped(stretch.accel, int(peak), rate):
                continue
            first = onset(stretch.accel, int(peak), rate)
            times.append(float(stretch.time[first]))
            ratios.append(float(np.sqrt(power[peak] / level[peak])))
            if power[peak] > limit * level[peak]:
                last = min(int(peak) + round(2 * NEAR * rate), stretch.time.size)
                loud = np.flatnonzero(power[peak:last] > limit * level[peak:last] / 4)
                inside[stretch.source[first : peak + int(loud[-1]) + 2]] = True
    each = np.array(ratios)
    apart = each > apart_from(each)
    return Knocks(np.array(times)[apart], each[apart], inside, wild)


def beyond_chance(total: int, rate: float) -> float:
    """Return the power over the local level that noise exceeds in one of 1000 recordings of `total` samples."""
    return float(f_ratio.isf(ALARM / total, 3, 3 * (1 - 2 * CUT / rate) * (FAR - NEAR) * rate))


def alone(peaks: Peaks, power: Array, rate: float) -> Peaks:
    """Return the peaks that are no faint echo of a much larger one near by."""
    near = np.abs(peaks[:, None] - peaks) < ECHO * rate
    return peaks[power[peaks] >= FAINT**2 * np.max(near * power[peaks], axis=1, initial=0.0)]


def apart_from(ratios: Array) -> float:
    """Return the ratio beyond which peaks are too many for the tail of the others, or of each other.

    Where all N peaks are beyond r, none lies between: a tail does that with a probability of (4 / r)^2N at most.
    """
    ordered = np.sort(ratios)[::-1]
    if ordered.size and ordered[-1] > FAR_OFF * HEAVY and (HEAVY / ordered[-1]) ** (2 * ordered.size) < ALARM:
        return FAR_OFF * HEAVY
    knocks = 0  # the largest are; each that is leaves a shorter tail to the others
    while True:
        threshold = HEAVY * float(np.sqrt(max(1, ordered.size - knocks) / BEYOND))
        more = int(np.sum(ordered > threshold))
        if more == knocks:
            return threshold
        knocks = more


def high(accel: Array, taps: Array) -> Array:
    """Return the power (m,) of accel (m, 3) above 15 Hz, mean of the axes."""
    left = accel - accel.mean(axis=0)
    return np.asarray(np.mean(fftconvolve(left, taps[:, None], mode="same", axes=0) ** 2, axis=1))


def local_level(power: Array, rate: float) -> Array:
    """Return the larger of the levels (m,) just before and just after each sample, a median over 0.85 s."""
    near, far = round(NEAR * rate), round(FAR * rate)
    width = (far - near) | 1
    middle = median_filter(power, width, mode="nearest") / (chi2.median(3) / 3)
    shift = near + width // 2
    ends = np.arange(power.size)
    before, after = middle[(ends - shift).clip(0)], middle[(ends + shift).clip(max=power.size - 1)]
    return np.maximum(np.maximum(before, after), 1e-16)


def single(stretch: Stretch, peak: int, taps: Array, limit: float, size: int) -> bool:
    """Return whether one wild sample makes the peak: with it filled in, nothing is left."""
    around = slice(max(0, peak - size), min(stretch.time.size, peak + size + 1))
    piece, one = stretch.accel[around], np.zeros(around.stop - around.start, dtype=bool)
    one[peak - around.start] = True
    left = high(smooth_fill(piece, one), taps)
    near = slice(max(0, peak - around.start - 3), peak - around.start + 4)
    return bool(left[near].max() < limit)


def stepped(accel: Array, peak: int, rate: float) -> bool:
    """Return whether the reading only goes over from one value to another, as where a held limb is let go.

    A knock leaves the straight way between the values before and after it, and by more than these differ; the slope
    that they share is the motion's. A peak is farther from the ends of a stretch than all that is looked at.
    """
    near, far = max(2, round(OVER * rate)), max(4, round(2 * OVER * rate))
    place = np.arange(-far, far + 1)
    before, after, between = place <= -near, place >= near, np.abs(place) <= near
    piece = accel[peak + place]
    slope = np.mean([np.polyfit(place[part], piece[part], 1)[0] for part in (before, after)], axis=0)
    piece = piece - slope * place[:, None]
    low = piece[before].mean(axis=0)
    change = piece[after].mean(axis=0) - low
    way = piece[between] - low
    share = np.clip(way @ change / max(float(change @ change), 1e-12), 0, 1)
    off = np.linalg.norm(way - share[:, None] * change, axis=1)
    return bool(off.max() < ASTRAY * np.linalg.norm(change))


def onset(accel: Array, peak: int, rate: float) -> int:
    """Return the sample at which a knock begins: where second differences first rise to a share of their largest."""
    start = max(1, peak - max(2, round(0.05 * rate)))
    stop = min(len(accel) - 1, peak + max(2, round(0.02 * rate)))
    bend = np.linalg.norm(np.diff(accel[start - 1 : stop + 1], 2, axis=0), axis=1)
    return start + int(np.argmax(bend > ONSET * bend.max()))
