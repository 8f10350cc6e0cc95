"""What an accelerometer reads above 15 Hz: its power, the level of that before and after, and where it has peaks."""

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import fftconvolve, find_peaks, firwin
from scipy.stats import chi2
from scipy.stats import f as f_ratio

from imubench.arrays import Array
from imubench.diagnosis.config.samples import HIGH_BAND
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.samples.even_grid import Stretch
from imubench.diagnosis.samples.sample_faults import Mask

Peaks = np.ndarray[tuple[int], np.dtype[np.int64]]


def high_pass(rate: float) -> Array:
    """Return the filter (taps,) that leaves what is above 15 Hz."""
    taps = firwin(
        int(HIGH_BAND.window_s * rate) | 1,
        HIGH_BAND.pass_hz,
        pass_zero=False,
        window=("kaiser", HIGH_BAND.kaiser_beta),
        fs=rate,
    )
    return np.asarray(taps)


def quick_power(
    stretch: Stretch, taps: Array, rate: float, skip: Mask, step: float, doubted: Mask | None = None
) -> tuple[Array, Array, Array]:
    """Return the power (m,) above 15 Hz of a stretch, 0 where no knock may begin, its local level (m,), and the bar
    (m,) that a peak is measured by.

    Samples of `skip` (n,) begin none; no level is below that of rounding. Near an end, where half of what the filter
    sees is made up and nobody knows what was before, and at `doubted` samples (n,) the bar is above the level. A
    filter's response to an unknown past is as loud as the motion there, so what knocks more faintly is not heard.
    """
    far, power = round(HIGH_BAND.level_to_s * rate), high(stretch.accel, taps)
    level = np.maximum(local_level(power, rate), step**2 / 12)
    unsure = np.zeros(power.size, dtype=bool) if doubted is None else doubted[stretch.source]
    unsure[:far], unsure[max(far, power.size - far) :] = True, True
    power[skip[stretch.source]] = 0.0
    return power, level, np.where(unsure, HIGH_BAND.unsure_factor**2, 1.0) * level


def peaks_of(power: Array, least: Array, rate: float) -> Peaks:
    """Return the peaks of a power (m,) above the `least` (m,) that are no faint echo of a much larger one near by."""
    peaks, _ = find_peaks(power, height=least, distance=max(1, round(HIGH_BAND.one_knock_s * rate)))
    near = np.abs(peaks[:, None] - peaks) < HIGH_BAND.echo_s * rate
    return peaks[power[peaks] >= HIGH_BAND.echo_share**2 * np.max(near * power[peaks], axis=1, initial=0.0)]


def extended(accel: Array, more: int) -> Array:
    """Return accel (m, 3) with `more` samples on either side, oddly about its ends: value and slope go on."""
    return np.pad(accel, ((more, more), (0, 0)), "reflect", reflect_type="odd")


def high(accel: Array, taps: Array) -> Array:
    """Return the power (m,) of accel (m, 3) above 15 Hz, mean of the axes; beyond its ends it goes on oddly."""
    long = extended(accel - accel.mean(axis=0), taps.size // 2)
    return np.asarray(np.mean(fftconvolve(long, taps[:, None], mode="valid", axes=0) ** 2, axis=1))


def local_level(power: Array, rate: float) -> Array:
    """Return the larger of the levels (m,) just before and just after each sample, a median over 0.85 s.

    Nearer to an end it is that of the other side; where both are near, of all.
    """
    near, far = round(HIGH_BAND.level_from_s * rate), round(HIGH_BAND.level_to_s * rate)
    width = (far - near) | 1
    middle = median_filter(power, width, mode="nearest")
    shift = near + width // 2
    ends = np.arange(power.size)
    before, after = middle[(ends - shift).clip(0)], middle[(ends + shift).clip(max=power.size - 1)]
    before[:far], after[max(0, power.size - far) :] = 0.0, 0.0
    level = np.where((before > 0) | (after > 0), np.maximum(before, after), np.median(power))
    return np.maximum(level / (chi2.median(3) / 3), 1e-16)


def beyond_chance(total: int, rate: float) -> float:
    """Return the power over the local level that noise exceeds in one of 1000 recordings of `total` samples."""
    return float(
        f_ratio.isf(
            STATISTICS.false_alarms_per_recording / total,
            3,
            3 * (1 - 2 * HIGH_BAND.pass_hz / rate) * (HIGH_BAND.level_to_s - HIGH_BAND.level_from_s) * rate,
        )
    )
