"""Knocks too faint for the raw samples: twice as loud above 15 Hz as noise ever is, and not as loud as a hand's peaks.

Of stationary noise a recording has one peak beyond the limit in a thousand recordings, and two in two million; a knock
that raises the power there tenfold lies beyond it. What a hand or a contact does lies there too, so such peaks are held
against the fit (`struck`), all together: alone they are as faint as what else is left.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks, firwin

from imubench.arrays import Array
from imubench.diagnosis.raw import RING, spread
from imubench.diagnosis.raw_grid import stretches
from imubench.diagnosis.raw_knocks import (
    BETA,
    CUT,
    LENGTH,
    NEAR,
    SLOWEST,
    TOGETHER,
    alone,
    beyond_chance,
    high,
    local_level,
    onset,
    stepped,
)
from imubench.recording import Imu

Mask = NDArray[np.bool_]
Window = tuple[float, float]

FEWEST = 2  # peaks: one may be anything that happens once
SHARE = 0.25  # of a peak's power: as long as that a knock lasts


def faint_knocks(imu: Imu, bad: Mask, step: float) -> tuple[Window, ...]:
    """Return the stretches (s) of peaks beyond chance, at least two; samples `bad` (n,) and their neighbours are none.

    Readings rounded to `step` (0: none) are never quieter than that.
    """
    rate = imu.rate
    if rate < SLOWEST:
        return ()
    size = int(LENGTH * rate) | 1
    taps = firwin(size, CUT, pass_zero=False, window=("kaiser", BETA), fs=rate)
    skip = spread(bad, RING)
    whole = [s for s in stretches(imu.time, imu.gyro, imu.accel, bad) if s.time.size >= 2 * size]
    limit = beyond_chance(sum(s.time.size for s in whole), rate) if whole else np.inf
    found = []
    for stretch in whole:
        power = high(stretch.accel, taps)
        level = np.maximum(local_level(power, rate), step**2 / 12)
        power[: size // 2], power[-(size // 2) :] = 0.0, 0.0
        power[skip[stretch.source]] = 0.0
        peaks, _ = find_peaks(power, height=limit * level, distance=max(1, round(TOGETHER * rate)))
        for peak in alone(peaks, power, rate):
            if not stepped(stretch.accel, int(peak), rate):
                found.append(lasting(stretch.time, stretch.accel, power, int(peak), rate))
    return tuple(found) if len(found) >= FEWEST else ()


def lasting(time: Array, accel: Array, power: Array, peak: int, rate: float) -> Window:
    """Return from when to when (s) a knock lasts, of accel (m, 3) whose power above 15 Hz (m,) has its peak there."""
    first = min(onset(accel, peak, rate), peak - 1)
    loud = np.flatnonzero(power[peak : peak + round(NEAR * rate)] > SHARE * power[peak])
    return float(time[first]), float(time[min(peak + int(loud[-1]) + 1, len(time) - 1)])


__all__ = ["faint_knocks"]
