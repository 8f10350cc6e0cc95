"""Knocks too faint for the raw samples: louder above 15 Hz than noise is, and not as loud as a quick hand's peaks.

Of stationary noise one recording in a thousand has a peak beyond the limit, one in two million has two; a knock that
raises the power there twelvefold lies beyond it. What a hand or a contact does lies there too, so such peaks are held
against the fit (`verdict.impacts`), all together: alone they are as faint as what else is left.
"""

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.samples import HIGH_BAND, IMPACT, SCREENING
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.samples.checks import spread
from imubench.diagnosis.samples.even_grid import stretches
from imubench.diagnosis.samples.high_band import beyond_chance, high_pass, peaks_of, quick_power
from imubench.diagnosis.samples.impacts import onset, stepped
from imubench.diagnosis.windows import Window
from imubench.recording import Imu

Mask = NDArray[np.bool_]


def faint_knocks(imu: Imu, bad: Mask, step: float) -> tuple[Window, ...]:
    """Return the stretches (s) of peaks beyond chance, at least two; samples `bad` (n,) and their neighbours are none.

    Readings rounded to `step` (0: none) are never quieter than that.
    """
    rate = imu.rate
    if rate < IMPACT.least_rate_hz:
        return ()
    taps, skip = high_pass(rate), spread(bad, SCREENING.clip_ring_samples)
    whole = [s for s in stretches(imu.time, imu.gyro, imu.accel, bad) if s.time.size >= 2 * taps.size]
    limit = beyond_chance(sum(s.time.size for s in whole), rate) if whole else np.inf
    found = []
    for stretch in whole:
        power, _, bar = quick_power(stretch, taps, rate, skip, step)
        for peak in peaks_of(power, limit * bar, rate):
            if not stepped(stretch.accel, int(peak), rate):
                found.append(lasting(stretch.time, stretch.accel, power, int(peak), rate))
    return tuple(found) if len(found) >= EVIDENCE.events else ()


def lasting(time: Array, accel: Array, power: Array, peak: int, rate: float) -> Window:
    """Return from when to when (s) a knock lasts, of accel (m, 3) whose power above 15 Hz (m,) has its peak there."""
    first = min(onset(accel, peak, rate), peak - 1)
    loud = np.flatnonzero(
        power[peak : peak + round(HIGH_BAND.level_from_s * rate)] > SCREENING.lasting_share * power[peak]
    )
    return float(time[first]), float(time[min(peak + int(loud[-1]) + 1, len(time) - 1)])


__all__ = ["faint_knocks"]
