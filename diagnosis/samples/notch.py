"""A hum taken out of an IMU's samples before the fit: all of one that shakes the sensor, of others what is not steady.

`vibration` is a steady line in the accelerometer, and a fit has its law. A motor on the segment turns the sensor as
well, and its frequency wanders: that is no such line. The motion's splines follow it up to half their knots' rate, and
a mount on springs resounds with it. A hand moves nothing at the frequencies at which hums are heard, so where the
gyroscope hums too the band about it goes, with as little of anything else: no delay, nothing of the motion below.

Where it does not, the line stays, and what wanders beside it goes: sidebands A^2 D / (2 pi d)^2 off by d Hz, of a phase
that diffuses by D rad^2/s. Of a loud hum they are louder than the noise for some Hz on either side, and would be taken
for a soft mount.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.signal import butter, sosfiltfilt
from scipy.special import polygamma

from imubench.arrays import Array
from imubench.diagnosis.config.samples import NOISE_FLOOR, NOTCH, TONE
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.samples.even_grid import stretches
from imubench.diagnosis.samples.noise_floor import MEDIAN_OVER_MEAN, densities, white_level
from imubench.diagnosis.samples.sample_faults import Mask
from imubench.diagnosis.samples.tones import contrast
from imubench.diagnosis.samples.tones import line as loudest_line
from imubench.recording import Imu


def turns_with_hum(imu: Imu, frequency: float, skip: Mask) -> bool:
    """Return whether the gyroscope hums at a frequency in Hz; `skip` (n,) are samples that do not count."""
    rate = 1 / float(np.median(np.diff(imu.time)))
    pieces = stretches(imu.time, imu.gyro, imu.accel, skip)
    none = np.zeros(imu.time.size, dtype=bool)
    width = 2 * round(TONE.window_s * rate / 2)
    frequency_of = np.fft.rfftfreq(width, 1 / rate)
    near = np.flatnonzero(np.abs(frequency_of - frequency) <= NOTCH.half_width_hz)
    accel, gyro = (contrast(densities(pieces, p, width, none)[0], frequency_of[1])[:, near] for p in ("accel", "gyro"))
    heard = accel.max(axis=1) > TONE.log_contrast
    if heard.sum() < NOISE_FLOOR.windows:
        return False
    at = np.argmax(accel[heard], axis=1)  # where it is in the accelerometer: the gyroscope's own maximum is chance
    # the logarithm of three axes' power, a chi-square of six degrees, has the variance psi'(3)
    chance = STATISTICS.rare_sigmas * float(np.sqrt(polygamma(1, 3) / NOISE_FLOOR.windows))
    return bool(np.mean(gyro[heard][np.arange(len(at)), at]) > chance)


def without_hum(imu: Imu, frequency: float, skip: Mask) -> tuple[Array, Array]:
    """Return rates and specific forces (n, 3) without the band about a hum in Hz; those of `skip` (n,) as they were."""
    rate = 1 / float(np.median(np.diff(imu.time)))
    sos = about(frequency, NOTCH.half_width_hz, rate)
    gyro, accel = imu.gyro.copy(), imu.accel.copy()
    for s in stretches(imu.time, imu.gyro, imu.accel, skip):
        if s.time.size >= NOTCH.least_stretch_s * rate:
            own = ~s.filled
            for out, x in ((gyro, s.gyro), (accel, s.accel)):
                out[s.source[own]] -= sosfiltfilt(sos, x, axis=0)[own]
    return gyro, accel


def without_further_hums(imu: Imu, skip: Mask) -> Imu:
    """Return an IMU without the bands about all further lines with which its gyroscope hums, too.

    What shakes a segment shakes it at several frequencies, and at their images. Each that is taken out is louder than
    all noise of the accelerometer; a fainter one may be the skirt of another, and takes noise with it.
    """
    rate = 1 / float(np.median(np.diff(imu.time)))
    while True:
        pieces = stretches(imu.time, imu.gyro, imu.accel, skip)
        levels = {part: white_level(pieces, part, rate, skip) for part in ("gyro", "accel")}
        noise = {part: level.std for part, level in levels.items() if level is not None}
        found = loudest_line(pieces, rate, skip, noise)
        if found is None or float(np.mean(found.amplitude**2)) / 2 <= noise.get("accel", np.inf) ** 2:
            return imu
        if not turns_with_hum(imu, found.frequency, skip):
            return imu
        gyro, accel = without_hum(imu, found.frequency, skip)
        imu = replace(imu, gyro=gyro, accel=accel)


def with_steady_hum(imu: Imu, frequency: float, skip: Mask) -> Array:
    """Return specific forces (n, 3) in which a hum in Hz is a steady line, as strong; those of `skip` (n,) stay.

    A line alone is weaker: of a phase that wanders by s rad it keeps exp(-s^2 / 2).
    """
    rate = 1 / float(np.median(np.diff(imu.time)))
    pieces = [s for s in stretches(imu.time, imu.gyro, imu.accel, skip) if s.time.size >= NOTCH.least_stretch_s * rate]
    if not pieces:
        return imu.accel
    sos = about(frequency, NOTCH.half_width_hz, rate)
    time = np.concatenate([s.time for s in pieces])
    heard = np.concatenate([sosfiltfilt(sos, s.accel, axis=0) for s in pieces])
    inner = [
        np.clip(np.minimum(s.time - s.time[0], s.time[-1] - s.time) / NOTCH.least_stretch_s, 0.0, 1.0) for s in pieces
    ]
    line = steady(time, heard, frequency, np.concatenate(inner))  # at its ends a filter rings
    each = np.cumsum([s.time.size for s in pieces])[:-1]
    left = np.split(np.concatenate([s.accel for s in pieces]) - line, each)
    reach = sidebands(left, rate, frequency)
    if not reach:
        return imu.accel
    sos = about(frequency, reach, rate)
    wandering = np.concatenate([sosfiltfilt(sos, x, axis=0) for x in left])
    weaker = np.sqrt(np.sum(line**2) / np.sum((line + wandering) ** 2))
    accel = imu.accel.copy()
    for s, x in zip(pieces, np.split(line / weaker - line - wandering, each), strict=True):
        accel[s.source[~s.filled]] += x[~s.filled]
    return accel


def steady(time: Array, values: Array, frequency: float, weight: Array | None = None) -> Array:
    """Return the strongest steady line (n, 3) near a frequency in Hz in values (n, 3) at times (n,), each so heavy."""
    weight = np.ones_like(time) if weight is None else weight
    turned = np.exp(-2j * np.pi * frequency * time)[:, None] * values * weight[:, None]
    bins = ((time - time[0]) * 8 * NOTCH.half_width_hz).astype(
        int
    )  # what is within `half_width_hz` turns there by an eighth of a round at most
    binned = np.zeros((bins[-1] + 1, 3), dtype=complex)
    np.add.at(binned, bins, turned)
    power = np.sum(np.abs(np.fft.fft(binned, NOTCH.grid_factor * len(binned), axis=0)) ** 2, axis=1)
    off = np.fft.fftfreq(NOTCH.grid_factor * len(binned), 1 / (8 * NOTCH.half_width_hz))
    best = frequency + float(off[np.argmax(np.where(np.abs(off) <= NOTCH.half_width_hz, power, 0.0))])
    for _ in range(NOTCH.newton_steps):
        line, slope = nearest(time, values, best, weight)
        best += float(np.sum(weight[:, None] * slope * (values - line)) / np.sum(weight[:, None] * slope**2))
    return nearest(time, values, best, weight)[0]


def nearest(time: Array, values: Array, frequency: float, weight: Array) -> tuple[Array, Array]:
    """Return the line (n, 3) of a frequency in Hz that is nearest to values (n, 3), and how it moves with that."""
    waves = np.stack([np.cos(2 * np.pi * frequency * time), np.sin(2 * np.pi * frequency * time)], axis=1)
    root = np.sqrt(weight)[:, None]
    sizes = np.linalg.lstsq(waves * root, values * root, rcond=None)[0]
    turned = waves[:, ::-1] * [-1.0, 1.0]
    return waves @ sizes, 2 * np.pi * (time - time.mean())[:, None] * (turned @ sizes)


def sidebands(pieces: list[Array], rate: float, frequency: float) -> float:
    """Return the distance in Hz up to which residuals (n, 3) beside a line are louder than noise; 0 where nowhere."""
    x = max(pieces, key=len)
    off = np.abs(np.fft.rfftfreq(len(x), 1 / rate) - frequency)
    power = np.sum(np.abs(np.fft.rfft(x * np.hanning(len(x))[:, None], axis=0)) ** 2, axis=1)
    beside = float(np.median(power[(off > NOTCH.half_width_hz) & (off < 2.5 * NOTCH.half_width_hz)])) / MEDIAN_OVER_MEAN
    loud = 0.0
    for a, b in pairwise((0.0, *NOTCH.reach_hz)):
        ring = power[(off >= a) & (off < b)]
        if ring.size and np.mean(ring) > beside * (
            1 + STATISTICS.rare_sigmas / np.sqrt(2 * ring.size)
        ):  # a window's bins go together
            loud = b
    return loud


def about(frequency: float, reach: float, rate: float) -> Array:
    """Return the filter that lets pass what is about a frequency in Hz, as second-order sections."""
    band = np.clip([frequency - reach, frequency + reach], 0.01 * rate, 0.49 * rate)
    return np.asarray(butter(2, band, btype="bandpass", fs=rate, output="sos"))


__all__ = ["turns_with_hum", "with_steady_hum", "without_further_hums", "without_hum"]
