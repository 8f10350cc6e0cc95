"""A recording below a frequency: what every IMU read, low-passed forward and backward on its own samples.

docs/band.md says what that does to the constraints of a hinge and to an estimate's covariance.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.paired import LONGEST_GAP
from imubench.recording import Imu, Recording, positive

ORDER = 4  # of the Butterworth filter, which runs twice: at the band's edge half of the amplitude is left
EDGE = 1.0  # periods of the band that an end or a gap spoils, see `LowPass`
PAD = 3.0  # periods of the band by which a run is continued before it is filtered
EVEN = 0.02  # of a period by which stamps may leave an even grid and still be filtered as they are
ROUNDING = 1e-6  # of a sample's period, as stamps in seconds have it
QUIETEST = 0.1  # of the seconds of a recording, in which hardly anything but noise is left
NOISE_ROWS = np.sqrt(70.0)  # of fourth differences, whose squared weights add up to 70


@dataclass(frozen=True)
class LowPass:
    """A Butterworth filter of order 4 run forward and backward (no delay) over samples of one clock.

    Its slowest mode falls by exp(-2.4) in a period of the band, so what an end or a gap of the samples does to it is
    a tenth one period away. Nearer samples are left out.
    """

    hz: float  # where half of the amplitude is left
    period: float  # s between samples

    @property
    def power(self) -> float:
        """The part of white noise's power that passes: samples that are independent, of all samples."""
        from scipy.signal import sosfreqz  # here: long to import, and most commands do without

        _, response = sosfreqz(self._sections, worN=4096)
        return float(np.mean(np.abs(response) ** 4))

    @property
    def _sections(self) -> Array:
        from scipy.signal import butter  # here: long to import, and most commands do without

        return np.asarray(butter(ORDER, 2.0 * self.hz * self.period, output="sos"))

    def apply(self, run: Array, edge: float = EDGE) -> Array:
        """Return the filtered columns of an unbroken run (n, ...) of even samples, without the two spoilt ends.

        Complex columns are filtered as they are. The result has `lost(edge)` rows less at either end.
        """
        from scipy.signal import sosfiltfilt  # here: long to import, and most commands do without

        pad = min(len(run) - 1, round(PAD / (self.hz * self.period)))
        whole = sosfiltfilt(self._sections, run, axis=0, padlen=pad)
        cut = self.lost(edge)
        return np.asarray(whole[cut : len(whole) - cut])

    def lost(self, edge: float = EDGE) -> int:
        """Return how many samples are left out at either end of a run."""
        return int(np.ceil(edge / (self.hz * self.period) - ROUNDING))

    @property
    def shortest(self) -> int:
        """The fewest samples of a run of which something is left: as much as both ends lose, once more."""
        return 4 * self.lost() + 1


def runs(time: Array, period: float) -> list[slice]:
    """Return the runs of stamps (n,) in s without a gap of over 2.5 periods between neighbours."""
    ends = [0, *(np.flatnonzero(np.diff(time) > LONGEST_GAP * period) + 1), time.size]
    return [slice(a, b) for a, b in pairwise(ends)]


def usual_period(time: Array) -> float:
    """Return the median step in s of stamps (n,); infinite for a single one."""
    return float(np.median(np.diff(time))) if time.size > 1 else np.inf


def below(time: Array, columns: Array, hz: float, name: str) -> tuple[NDArray[np.bool_], Array]:
    """Low-pass columns (n, k) with stamps (n,) in s; return which samples are left (n,), and their values (m, k).

    Runs between gaps are filtered each for itself. Uneven stamps are filtered on an even grid, to which a cubic
    spline carries them and back. Raises `InputError` for a rate too low or runs too short for the band.
    """
    period = usual_period(time)
    _check_rate(period, hz, name)
    kept, parts, longest = np.zeros(time.size, dtype=bool), [], 0.0
    for run in runs(time, period):
        stamps = time[run]
        length = float(stamps[-1] - stamps[0])
        longest = max(longest, length)
        count = round(length / period) + 1
        if stamps.size < 4 or count < LowPass(hz, period).shortest:
            continue
        first, last = np.searchsorted(stamps, [stamps[0] + EDGE / hz, stamps[-1] - EDGE / hz])
        kept[run.start + first : run.start + last] = True
        parts.append(_filtered(LowPass(hz, length / (count - 1)), stamps, columns[run], slice(first, last), count))
    if not parts:
        raise InputError(
            f"{name}: expected {4 * EDGE / hz:.3g} s without a gap for a band of {hz:g} Hz, got at most {longest:.3g} s"
        )
    return kept, np.concatenate(parts)


def _filtered(low_pass: LowPass, stamps: Array, columns: Array, inside: slice, count: int) -> Array:
    grid = stamps[0] + low_pass.period * np.arange(count)
    if count == stamps.size and np.abs(stamps - grid).max() < EVEN * low_pass.period:
        return low_pass.apply(columns, edge=0.0)[inside]
    even = low_pass.apply(CubicSpline(stamps, columns)(grid), edge=0.0)
    return np.asarray(CubicSpline(grid, even)(stamps[inside]))


def _check_rate(period: float, hz: float, name: str) -> None:
    positive(hz, "band")
    if not hz * period < 0.5 - ROUNDING:
        raise InputError(
            f"{name}: expected a band below {0.5 / period:.4g} Hz, half of the {1 / period:.4g} samples a second, "
            f"got {hz:g} Hz"
        )


def banded(recording: Recording, hz: float) -> Recording:
    """Return a recording whose IMUs read what was below `hz` Hz; all else stays as it was.

    Samples within a period of the band from an end or a gap are left out. Noise stds, declared or else estimated,
    become those of the filtered samples; these are correlated, see `independent`. Raises `InputError` for a rate too
    low, or runs too short, for the band.
    """
    return replace(recording, imus=tuple(_imu_below(imu, hz) for imu in recording.imus))


def _imu_below(imu: Imu, hz: float) -> Imu:
    kept, values = below(imu.time, np.hstack([imu.gyro, imu.accel]), hz, imu.name)
    left = np.sqrt(LowPass(hz, usual_period(imu.time)).power)
    gyro, accel = (
        left * (quiet_noise(signal, imu.rate) if std is None else std)
        for signal, std in ((imu.gyro, imu.gyro_noise_std), (imu.accel, imu.accel_noise_std))
    )
    return replace(
        imu, time=imu.time[kept], gyro=values[:, :3], accel=values[:, 3:], gyro_noise_std=gyro, accel_noise_std=accel
    )


def quiet_noise(signal: Array, rate: float, quietest: float = QUIETEST) -> float:
    """Return the std of a sample's white noise in a signal (n, 3), by the second at that quantile of all.

    From fourth differences, which hardly see slow motion. At 40 Hz they see a hand's, and a mount that rocks: what is
    returned is rather too large, unless a second is quiet.
    """
    squares = np.mean(np.diff(signal, 4, axis=0) ** 2, axis=1)
    size = max(1, round(rate))
    if squares.size < size:
        return float(np.sqrt(squares.mean()) / NOISE_ROWS) if squares.size else 0.0
    seconds = squares[: squares.size // size * size].reshape(-1, size).mean(axis=1)
    return float(np.sqrt(np.quantile(seconds, quietest)) / NOISE_ROWS)


def independent(recording: Recording, hz: float) -> float:
    """Return the part of the samples that white noise leaves independent below `hz` Hz: of the fastest IMU, 0 to 1.

    A least-squares fit that takes filtered samples for independent states a covariance too small by this factor,
    if what it fits varies within the band.
    """
    powers = [LowPass(hz, usual_period(imu.time)).power for imu in recording.imus]
    return min(powers, default=1.0)
