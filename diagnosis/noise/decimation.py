"""Samples at a lower rate for the fit, where an IMU reads white noise alone above the motion.

Readings whose motion ends at f are told as well by fewer samples. With the rate R and the roll-off b they are

    y(t) = sum_n h(R (t - t_n)) x(t_n) / sum_n h(R (t - t_n)),    H(f)^2 + H(R - f)^2 = 1,
    H = 1 up to (1 - b) R / 2, 0 from (1 + b) R / 2 on

h being the scaling function of Meyer's wavelets (Daubechies, Ten lectures on wavelets, 1992, section 4.2) in a Kaiser
window: what is below (1 - b) R / 2 stays as it is, and white noise of std s becomes white noise of sqrt(sum_n w_n^2) s,
w_n the weights of a sample. So the fit has the same to go by, in a time that its samples and knots grow with.

What acts in single moments or jumps has no end in frequency: nothing is changed where the raw samples show a knock, a
step, a limit, a loss or a tone, nor beside free swings, in which friction reverses at once. Nor where no spline of
its own holds the force, as beside a measured place or a pivot that stays: a second derivative needs more knots.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.signal import welch
from scipy.stats import chi2

from imubench.arrays import Array
from imubench.diagnosis.config.noise import DECIMATION
from imubench.diagnosis.config.samples import HIGH_BAND, NOISE_FLOOR
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.problem.averaging import AS_RECORDED, Averaging
from imubench.diagnosis.problem.rig_kinematics import FORCE, Rig
from imubench.diagnosis.samples.faint_impacts import faint_knocks
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART
from imubench.diagnosis.samples.screening import SampleChecks
from imubench.effects import traits_of
from imubench.effects.traits import Fault
from imubench.recording import Imu, Recording, span_of


@dataclass(frozen=True)
class Decimated:
    """A recording whose IMUs have fewer samples, or as many as they had."""

    recording: Recording
    averaging: Averaging = AS_RECORDED
    notes: tuple[str, ...] = ()


def decimated(recording: Recording, samples: SampleChecks) -> Decimated:
    """Return a recording with as many samples of its IMUs as their motion needs; what is above it is noise alone.

    Args:
        recording: as the fit would see it.
        samples: what its raw samples say.
    """
    if not recording.imus or recording.free_swings or FORCE not in Rig.of(recording).widths:
        return Decimated(recording)
    if not all(smooth(imu, samples) for imu in recording.imus):
        return Decimated(recording)
    ends = motion_ends(recording)
    rate = 2 * max(DECIMATION.margin * ends / (1 - DECIMATION.roll_off), NOISE_FLOOR.least_hz)
    shortest = min(float(np.ptp(imu.time)) for imu in recording.imus)
    too_slow = rate * (1 + DECIMATION.roll_off) > min(imu.rate for imu in recording.imus)
    if too_slow or 2 * DECIMATION.reach > DECIMATION.lost * shortest * rate:
        return Decimated(recording)
    fewer = [at_rate(imu, rate) for imu in recording.imus]
    shares = {f"{imu.name}.{part}": share for imu, share in fewer for part in UNIT_OF_PART}
    note = (
        f"Above {ends:.1f} Hz the IMUs read noise alone: the fit takes their samples at {rate:.1f} Hz, what is above "
        f"{(1 - DECIMATION.roll_off) * rate / 2:.1f} Hz filtered out."
    )
    return Decimated(
        replace(recording, imus=tuple(imu for imu, _ in fewer)), Averaging(shares, span_of(recording)[0]), (note,)
    )


def smooth(imu: Imu, samples: SampleChecks) -> bool:
    """Return whether an IMU's samples are even in time, all there, and nothing in them jumps."""
    clock, step = np.linspace(imu.time[0], imu.time[-1], imu.time.size, retstep=True)
    if np.max(np.abs(imu.time - clock)) > DECIMATION.jitter * step:
        return False
    told = [f for f in (*samples.findings, *samples.unless_stopped) if f.at == imu.name]
    if any(traits_of(f.effect).fault is not Fault.NOISY for f in told):
        return False
    if imu.name in samples.struck or any(f"{imu.name}.{part}" in samples.masks for part in UNIT_OF_PART):
        return False
    return not faint_knocks(imu, np.zeros(imu.time.size, dtype=bool), 0.0)


def motion_ends(recording: Recording) -> float:
    """Return the frequency in Hz above which no channel of any IMU has more power than white noise may have."""
    return max(end_of(x, imu.rate) for imu in recording.imus for x in (imu.gyro, imu.accel))


def end_of(readings: Array, rate: float) -> float:
    """Return the frequency in Hz above which no channel of readings (n, 3) has more than white noise, by bands.

    The noise is what the upper half of the spectrum has. A band of B Hz over T s has the power of a chi-squared with
    2 B T degrees of freedom, over these.
    """
    segment = min(round(NOISE_FLOOR.window_s * rate), len(readings))
    frequency, power = welch(readings, rate, nperseg=segment, axis=0)
    bins = max(1, round(DECIMATION.band_hz * segment / rate))
    count = (frequency.size - 1) // bins
    bands = power[1 : 1 + count * bins].reshape(count, bins, 3).mean(axis=1)
    tops = frequency[1 : 1 + count * bins].reshape(count, bins)[:, -1]
    free = 2 * bins * len(readings) / segment
    most = chi2.isf(STATISTICS.false_alarms_per_recording / (3 * count), free) / free
    level = np.median(bands[tops > rate / 4], axis=0)
    return float(np.max(tops[:, None] * (bands > most * level), initial=0.0))


def at_rate(imu: Imu, rate: float) -> tuple[Imu, float]:
    """Return an IMU's samples at a lower rate, and the std of white noise in them over that in its own."""
    reach, step, own = DECIMATION.reach / rate, 1 / rate, (imu.time[-1] - imu.time[0]) / (imu.time.size - 1)
    time = np.arange(imu.time[0] + reach, imu.time[-1] - reach, step)
    first = np.searchsorted(imu.time, time - reach)
    near = np.minimum(first[:, None] + np.arange(int(2 * reach / own) + 2), imu.time.size - 1)
    away = (time[:, None] - imu.time[near]) * rate
    weights = np.where(np.abs(away) < DECIMATION.reach, scaling_function()(away), 0.0)
    weights[:, 1:][near[:, 1:] == near[:, :-1]] = 0.0  # the last sample counts once
    weights /= weights.sum(axis=1, keepdims=True)
    gyro, accel = (np.einsum("nk,nkc->nc", weights, x[near]) for x in (imu.gyro, imu.accel))
    share = float(np.sqrt(np.mean(np.sum(weights**2, axis=1))))
    noise = {
        key: std * share
        for key in (f"{part}_noise_std" for part in UNIT_OF_PART)
        if (std := getattr(imu, key)) is not None
    }
    return replace(imu, time=time, gyro=gyro, accel=accel, rate=rate, **noise), share


@cache
def scaling_function() -> BSpline:
    """Return Meyer's scaling function of time in samples, in a window of `DECIMATION.reach` on either side."""
    most = (1 + DECIMATION.roll_off) / 2
    time = np.linspace(-DECIMATION.reach, DECIMATION.reach, 2 * DECIMATION.reach * DECIMATION.points + 1)
    f = np.linspace(0.0, most, time.size)
    x = np.clip((f - (1 - DECIMATION.roll_off) / 2) / DECIMATION.roll_off, 0.0, 1.0)
    passed = np.cos(np.pi / 2 * x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3))
    values = 2 * np.trapezoid(passed * np.cos(2 * np.pi * np.abs(time)[:, None] * f), f, axis=1)
    return make_interp_spline(time, values * np.kaiser(time.size, HIGH_BAND.kaiser_beta), k=5)


__all__ = ["Decimated", "decimated"]
