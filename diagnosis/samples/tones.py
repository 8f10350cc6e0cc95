"""Hums: a narrow line in the accelerometer's spectrum, above what a hand does.

In four-second windows, the logarithm of the power at a frequency over the median of its neighbourhood, 1 to 2.5 Hz
off, has the variance trigamma(3) = 0.395 where there is none, whatever the motion does to both. Its mean over K windows
in a row stands out from noise by z * 0.63 / sqrt(K), z for one false alarm in a thousand recordings among all
frequencies and spans of windows. A resonance driven by motion is broader than a line and seldom four times its
neighbourhood; the second to fourth harmonic of a strong line of the motion is no hum.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.special import digamma, polygamma
from scipy.stats import norm

from imubench.arrays import Array
from imubench.diagnosis.config.samples import NOISE_FLOOR, TONE
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.samples.even_grid import Stretch
from imubench.diagnosis.samples.noise_floor import MEDIAN_OVER_MEAN, densities
from imubench.diagnosis.samples.sample_faults import Mask


@dataclass(frozen=True)
class Line:
    """A hum."""

    frequency: float  # Hz, below half the rate
    error: float  # one standard deviation; a hum that wanders has its spread in it
    amplitude: Array  # (3,) m/s^2
    amplitude_error: Array  # (3,)
    windows: tuple[tuple[float, float], ...]  # s
    ratio: float  # of its power to the neighbourhood's


def line(stretches: tuple[Stretch, ...], rate: float, skip: Mask, noise: Mapping[str, float]) -> Line | None:
    """Return the strongest hum of a recording, None where there is none or it is too short (8 s) to tell.

    Samples that are lost may break a recording into few windows; a hum that stands out by far in each is one still.
    """
    width = 2 * round(TONE.window_s * rate / 2)
    power, times = densities(stretches, "accel", width, skip)
    if len(power) < TONE.broken_windows:
        return None
    frequency = np.asarray(np.fft.rfftfreq(width, 1 / rate), dtype=float)
    over = contrast(power, rate / width)
    lowest = above_motion(stretches, rate, skip, noise)
    use = np.flatnonzero(
        (frequency > lowest) & (frequency < rate / 2 - TONE.neighbours_to_hz) & ~harmonic(power, frequency)
    )
    span = strongest(over[:, use])
    if span is None:
        return None
    first, last, at = span
    return follow(stretches, rate, frequency, over, times, (first, last), int(use[at]))


def above_motion(stretches: tuple[Stretch, ...], rate: float, skip: Mask, noise: Mapping[str, float]) -> float:
    """Return the frequency in Hz from which a line is none of the motion's: twice what exceeds the noise.

    In the gyroscope every line counts as motion, in the accelerometer what is broader than a line.
    """
    if noise.keys() != {"gyro", "accel"}:
        return TONE.usual_least_hz
    width = 2 * round(TONE.window_s * rate / 2)
    frequency = np.fft.rfftfreq(width, 1 / rate)
    gyro, accel = (np.mean(densities(stretches, part, width, skip)[0], axis=0) for part in ("gyro", "accel"))
    broad = median_filter(accel, 2 * round(TONE.neighbours_to_hz / frequency[1]) + 1, mode="nearest")
    moved = frequency[(gyro > TONE.moved_power * noise["gyro"] ** 2) | (broad > TONE.moved_power * noise["accel"] ** 2)]
    return float(
        np.clip(
            2 * moved[moved < TONE.usual_least_hz].max(initial=0.0) + TONE.neighbours_from_hz,
            TONE.least_hz,
            TONE.usual_least_hz,
        )
    )


def contrast(power: Array, resolution: float) -> Array:
    """Return ln(power / neighbourhood) (windows, frequencies), zero on average where nothing stands out."""
    inner, outer = round(TONE.neighbours_from_hz / resolution), round(TONE.neighbours_to_hz / resolution)
    around = np.ones(2 * outer + 1, dtype=bool)
    around[outer - inner + 1 : outer + inner] = False
    beside = median_filter(power, footprint=around[None, :], mode="nearest")
    return np.log(power + 1e-300) - np.log(beside + 1e-300) - (float(digamma(3)) - np.log(3 * MEDIAN_OVER_MEAN))


def harmonic(power: Array, frequency: Array) -> Mask:
    """Return which frequencies (f,) are multiples of a line in the motion as strong as any, to its half a bin."""
    mean = np.mean(power, axis=0)
    low = np.flatnonzero((frequency > 1.0) & (frequency < TONE.usual_least_hz))
    out = np.zeros(frequency.size, dtype=bool)
    if not low.size:
        return out
    over = contrast(mean[None, :], frequency[1])[0]
    for i in low[(over[low] > TONE.log_contrast) & (mean[low] > TONE.main_share * mean[low].max())]:
        for k in TONE.harmonics:
            out |= np.abs(frequency - k * frequency[i]) <= frequency[1] * (1 + k / 2)
    return out


def strongest(over: Array) -> tuple[int, int, int] | None:
    """Return the span of windows [first, last) and the column of over (windows, k) that stand out most, if any do."""
    count, wide = over.shape
    if not wide:
        return None
    sums = np.concatenate([np.zeros((1, wide)), np.cumsum(over, axis=0)])
    best: tuple[float, int, int, int] = (0.0, 0, 0, 0)
    length, spans = count, 0
    while length >= min(NOISE_FLOOR.windows, count):
        starts = sorted({*range(0, count - length + 1, max(1, length // 2)), count - length})
        spans += len(starts)
        for first in starts:
            mean = (sums[first + length] - sums[first]) / length
            score = mean * np.sqrt(length / float(polygamma(1, 3)))
            for at in np.argsort(score)[-3:]:
                if score[at] > best[0] and np.median(over[first : first + length, at]) > TONE.log_contrast:
                    best = (float(score[at]), first, first + length, int(at))
        length //= 2
    # neighbouring windows share half their samples and the neighbourhood's median errs: 1.2 in all
    threshold = 1.2 * float(norm.isf(STATISTICS.false_alarms_per_recording / (wide * max(spans, 1))))
    return best[1:] if best[0] > threshold else None


def follow(
    stretches: tuple[Stretch, ...], rate: float, frequency: Array, over: Array, times: Array,
    span: tuple[int, int], at: int,
) -> Line:  # fmt: skip
    """Return the line seen in a span of windows at a frequency, followed to where it ends."""
    reach = max(1, round(TONE.wander_hz / frequency[1]))
    path = np.full(len(over), -1)
    middle = (span[0] + span[1]) // 2
    for order in (range(middle, len(over)), range(middle - 1, -1, -1)):
        here, missed = at, 0
        for w in order:
            low = max(1, here - reach)
            k = low + int(np.argmax(over[w, low : here + reach + 1]))
            if over[w, k] > TONE.log_contrast:
                path[w], here, missed = k, k, 0
            else:
                missed += 1
                if missed > NOISE_FLOOR.windows:
                    break
    seen = np.flatnonzero(path >= 0)
    found = np.array([_peak(frequency, over[w], path[w]) for w in seen])
    value = float(np.median(found))
    wander = 1.4826 * float(np.median(np.abs(found - value)))
    error = max(wander, 0.1 * frequency[1]) / np.sqrt(len(seen)) if wander < frequency[1] else float(np.std(found))
    amplitude, spread = amplitudes(stretches, rate, times[seen], found)
    windows: list[tuple[float, float]] = []
    for t in times[seen]:
        begin, end = float(t - TONE.window_s / 2), float(t + TONE.window_s / 2)
        if windows and begin <= windows[-1][1] + TONE.window_s / 2:
            windows[-1] = (windows[-1][0], end)
        else:
            windows.append((begin, end))
    ratio = float(np.exp(np.median(over[seen, path[seen]])))
    return Line(value, error, amplitude, spread, tuple(windows), ratio)


def _peak(frequency: Array, log_power: Array, k: int) -> float:
    """Return a line's frequency from a parabola through the three logarithms about its largest bin."""
    if not 0 < k < log_power.size - 1:
        return float(frequency[k])
    a, b, c = log_power[k - 1 : k + 2]
    bend = a - 2 * b + c
    shift = 0.5 * (a - c) / bend if bend < 0 else 0.0
    return float(frequency[k] + np.clip(shift, -0.5, 0.5) * frequency[1])


def amplitudes(stretches: tuple[Stretch, ...], rate: float, times: Array, frequency: Array) -> tuple[Array, Array]:
    """Return each axis' amplitude (3,) of a line at frequencies (w,) in windows about times (w,), and its error.

    One-second windows, so that a line that wanders is not smeared; signs are those against the strongest axis.
    """
    width = round(rate)
    taper = np.hanning(width + 2)[1:-1]
    taper /= taper.sum()
    found = []
    for stretch in stretches:
        for t, f in zip(times, frequency, strict=True):
            first = int(np.searchsorted(stretch.time, t)) - width // 2
            if first >= 0 and first + width <= stretch.time.size and stretch.time[0] <= t <= stretch.time[-1]:
                piece = stretch.accel[first : first + width]
                about = f + np.array([0.0, -TONE.noise_beside_hz, TONE.noise_beside_hz])
                turn = np.exp(-2j * np.pi * about[:, None] * np.arange(width) / rate)
                found.append(2 * (taper * turn) @ (piece - piece.mean(axis=0)))
    if not found:
        return np.zeros(3), np.zeros(3)
    each = np.array(found)  # (windows, line and both sides, axes)
    beside = np.median(np.abs(each[:, 1:]) ** 2, axis=(0, 1))  # noise adds its power to the line's
    size = np.sqrt(np.maximum(np.median(np.abs(each[:, 0]) ** 2, axis=0) - beside, 0.0))
    main = int(np.argmax(size))
    along = each[:, 0] * np.exp(-1j * np.angle(each[:, 0, main]))[:, None]  # the strongest axis' phase taken out
    sign = np.where(np.median(along.real, axis=0) < 0, -1.0, 1.0)
    spread = np.std(np.abs(each[:, 0]), axis=0)
    return sign * size, spread / np.sqrt(len(each)) + 1e-9
