"""A hum that shakes the whole sensor, taken out of its samples before the fit.

`vibration` is a steady line in the accelerometer, and a fit has its law. A motor on the segment turns the sensor as
well, and its frequency wanders: that is no such line. The motion's splines follow it up to half their knots' rate, and
a mount on springs resounds with it (on a telephone that vibrates at 45 Hz a rocking mount was worth 9,300 nat). A hand
moves nothing at the frequencies at which hums are heard, so where the gyroscope hums too the band about it goes, with
as little of anything else: no delay, nothing of the motion below.
"""

import numpy as np
from scipy.signal import butter, sosfiltfilt

from imubench.arrays import Array
from imubench.diagnosis.raw_grid import stretches
from imubench.diagnosis.raw_lines import SECONDS, STANDS, contrast
from imubench.diagnosis.raw_noise import densities
from imubench.diagnosis.raw_samples import Mask
from imubench.recording import Imu

WIDE = 2.0  # Hz on either side of a hum; one that wanders moves by 0.75 Hz from one window to the next
FEWEST = 4  # windows in which it is heard
TURNS = float(np.log(3.0))  # over its neighbourhood, 3.5 standard deviations of the mean of four windows
SETTLED = 1.0  # s, the shortest stretch that such a filter can be run over


def turning(imu: Imu, frequency: float, skip: Mask) -> bool:
    """Return whether the gyroscope hums at a frequency in Hz; `skip` (n,) are samples that do not count."""
    rate = 1 / float(np.median(np.diff(imu.time)))
    pieces = stretches(imu.time, imu.gyro, imu.accel, skip)
    none = np.zeros(imu.time.size, dtype=bool)
    width = 2 * round(SECONDS * rate / 2)
    frequency_of = np.fft.rfftfreq(width, 1 / rate)
    near = np.flatnonzero(np.abs(frequency_of - frequency) <= WIDE)
    accel, gyro = (contrast(densities(pieces, p, width, none)[0], frequency_of[1])[:, near] for p in ("accel", "gyro"))
    heard = accel.max(axis=1) > STANDS
    if heard.sum() < FEWEST:
        return False
    at = np.argmax(accel[heard], axis=1)  # where it is in the accelerometer: the gyroscope's own maximum is chance
    return bool(np.mean(gyro[heard][np.arange(len(at)), at]) > TURNS)


def hushed(imu: Imu, frequency: float, skip: Mask) -> tuple[Array, Array]:
    """Return rates and specific forces (n, 3) without the band about a hum in Hz; those of `skip` (n,) as they were."""
    rate = 1 / float(np.median(np.diff(imu.time)))
    band = np.clip([frequency - WIDE, frequency + WIDE], 0.01 * rate, 0.49 * rate)
    sos = butter(2, band, btype="bandpass", fs=rate, output="sos")
    gyro, accel = imu.gyro.copy(), imu.accel.copy()
    for s in stretches(imu.time, imu.gyro, imu.accel, skip):
        if s.time.size >= SETTLED * rate:
            own = ~s.filled
            for out, x in ((gyro, s.gyro), (accel, s.accel)):
                out[s.source[own]] -= sosfiltfilt(sos, x, axis=0)[own]
    return gyro, accel


__all__ = ["hushed", "turning"]
