"""Samples that are older than their stamps: a sensor renews its readings at its own pace, and is read at another.

A sensor that renews its readings f times a second, from a phase c on, is read at stamps t_n. What is read then is

    a_n = frac(f t_n + c) / f      s old,      y_n = x(t_n - a_n) = x(t_n) - a_n x'(t_n)

With f = 1000 Hz and 285.7 readings a second every other sample is half a millisecond older than its neighbours. Their
mean 1 / (2 f) is a late clock and stays; the rest is no noise: it grows with x', and the ages of neighbours alternate.
A sawtooth's first harmonic alone is sin(2 pi (f t + c)) / (pi f), which at the stamps of a rate r looks like one of
f_a = |f - k r|. The product of what the readings have above any motion and of their slope has a line there, of the
amplitude 1 / (pi f) beside the slope's square: so the line says f_a and, by its size, which k. Where the line is not
above the motion, nothing is said.

Of the two rates k r + f_a and (k + 1) r - f_a the alternation is the same; of the one the ages grow slowly and fall
back, of the other they fall slowly and jump up. That is within the band of the motion, where a measured attitude tells
(`_growing`). Without one the alternation alone is taken out.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize

from imubench.alignment import gyro_delay, optical_rate
from imubench.arrays import Array
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.samples.even_grid import stretches
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART
from imubench.errors import InputError
from imubench.recording import Imu, Pose, Recording
from imubench.slope import LEAST, MOTION, above_motion, slope_of

Mask = NDArray[np.bool_]
Line = tuple[float, float]
"""The rate f in Hz and the phase c in turns, from a sensor's first stamp on."""


@dataclass(frozen=True)
class Beat:
    """What a triple has above its motion, and how fast it changes, on an even grid."""

    time: Array  # (m,) s, since the sensor's first stamp
    high: Array  # (m, 3) above any motion; 0 where no sample counts
    slope: Array  # (m, 3) per s

    @classmethod
    def of(cls, imu: Imu, part: str, counts: Mask) -> "Beat | None":
        """Return those of the longest stretch without a gap; None where there is none."""
        found = stretches(imu.time, imu.gyro, imu.accel, np.zeros(imu.time.size, dtype=bool))
        long = max(found, key=lambda s: s.time.size, default=None)
        if long is None or long.time.size < LEAST:
            return None
        x, rate = long.part(part), 1 / float(np.median(np.diff(imu.time)))
        used = (counts[long.source] & ~long.filled)[:, None]
        return cls(long.time - imu.time[0], used * above_motion(x), used * slope_of(x, rate))

    @property
    def product(self) -> Array:
        """What has a line where ages beat (m,)."""
        return np.asarray(np.sum(self.high * self.slope, axis=1))

    def wave(self, frequency: float) -> tuple[complex, float]:
        """Return the wave at a frequency in Hz that goes with the slope, and the square that it explains.

        Least squares of a sin + b cos, as a + i b: near half the rate a line and its image are not apart.
        """
        turned = 2 * np.pi * frequency * self.time
        waves = np.stack([np.sin(turned), np.cos(turned)])
        square = (waves * np.sum(self.slope**2, axis=1)) @ waves.T
        pull = waves @ self.product
        found = np.linalg.lstsq(square, pull, rcond=None)[0]
        return complex(*found), float(found @ pull)

    def loudest(self, rate: float) -> tuple[float, float]:
        """Return the frequency in Hz of the strongest line above any motion, and its power over that of the others."""
        count = 4 * self.time.size
        frequency = np.fft.rfftfreq(count, 1 / rate)
        power = np.where(frequency > MOTION * rate, np.abs(np.fft.rfft(self.product, count)) ** 2, np.nan)
        best = int(np.nanargmax(power))
        return float(frequency[best]), float(power[best] * np.log(2) / max(float(np.nanmedian(power)), 1e-300))

    def left(self, line: Line) -> float:
        """Return what is left of its power without the ages of a line."""
        aged = self.high + above_motion(aged_by(self.time, (line,))[:, None] * self.slope)
        return float(np.sum(aged**2) / np.sum(self.high**2))


def aged_by(time: Array, lines: Sequence[Line]) -> Array:
    """Return by how much samples at times (n,) s are older than on average, in s; of several lines, their mean."""
    return np.asarray(np.mean([(np.mod(f * time + c, 1.0) - 0.5) / f for f, c in lines], axis=0))


def beat_of(beat: Beat, rate: float) -> tuple[Line, Line] | None:
    """Return the line of a triple's ages and that of its mirror; None where there is none beyond chance."""
    at, power = beat.loudest(rate)
    if power < np.log(beat.time.size / STATISTICS.false_alarms_per_recording):
        return None
    near = at + np.linspace(-1.0, 1.0, 41) / (beat.time[-1] - beat.time[0])
    at = float(near[np.argmax([beat.wave(f)[1] for f in near])])
    renewed = 1 / (np.pi * abs(beat.wave(at)[0]))
    nearest = round(renewed / rate - 0.5)
    pairs = [
        [(f, phase(beat, f)) for f in (k * rate + at, (k + 1) * rate - at)]
        for k in (nearest - 1, nearest, nearest + 1)
        if k >= 0
    ]
    least = min(pairs, key=lambda pair: min(beat.left(line) for line in pair))
    if least[0][0] != nearest * rate + at or min(beat.left(line) for line in least) >= 1.0:
        return None  # a line of another size than that of ages
    return settled(beat, least[0]), settled(beat, least[1])


def settled(beat: Beat, line: Line) -> Line:
    """Return the line near one whose sawtooth leaves least: its falls tell the phase better than its first harmonic."""
    turns = float(beat.time[-1])
    middle = line[0] * turns / 2 + line[1]

    def of(x: Array) -> Line:  # turns more in all, and in the middle: neither moves with the other
        return line[0] + x[0] / turns, float(middle + x[1] - (line[0] + x[0] / turns) * turns / 2)

    start = np.array([[0.0, 0.0], [0.05, 0.0], [0.0, 0.05]])
    best = minimize(
        lambda x: beat.left(of(x)), start[0], method="Nelder-Mead", options={"initial_simplex": start, "xatol": 1e-3}
    )
    return of(best.x)


def phase(beat: Beat, frequency: float) -> float:
    """Return the phase c in turns of ages with a frequency in Hz, which leave -a x' in the readings."""
    return float(np.angle(beat.wave(frequency)[0]) / (2 * np.pi))


def of_one_age(recording: Recording, masks: Mapping[str, Mask]) -> tuple[Recording, tuple[str, ...]]:
    """Return a recording whose samples are all as old as they are on average, and what was found, in words.

    Args:
        recording: its stamps even but for gaps.
        masks: samples (n,) that count, by triple; of others nothing is read.
    """
    imus, said = [], []
    for imu in recording.imus:
        lines = ages_of(
            imu, masks, next((p for p in recording.poses if p.segment == recording.carrier(imu.name)), None)
        )
        since = imu.time - imu.time[0]
        rate = 1 / float(np.median(np.diff(imu.time))) if lines else 0.0
        younger = {
            part: (x := getattr(imu, part)) + aged_by(since, own)[:, None] * slope_of(x, rate)
            for part, own in lines.items()
        }
        imus.append(replace(imu, **younger))
        if lines:
            fastest = max(f for own in lines.values() for f, _ in own)
            said.append(
                f"{imu.name} renews its readings some {fastest:.0f} times a second and is read {rate:.1f} times: its "
                f"samples are up to {1e3 / fastest:.1f} ms older than their stamps, each another time. Taken out."
            )
    return replace(recording, imus=tuple(imus)), tuple(said)


def ages_of(imu: Imu, masks: Mapping[str, Mask], pose: Pose | None) -> dict[str, tuple[Line, ...]]:
    """Return the lines of the ages of an IMU's triples, by triple; of none that shows none.

    The gyroscope tells the rate, which is the device's; the accelerometer is renewed at another moment.
    """
    every = np.ones(imu.time.size, dtype=bool)
    if imu.time.size < LEAST:
        return {}
    rate = 1 / float(np.median(np.diff(imu.time)))
    beats = {part: Beat.of(imu, part, masks.get(f"{imu.name}.{part}", every)) for part in UNIT_OF_PART}
    gyro = beats["gyro"]
    found = beat_of(gyro, rate) if gyro is not None else None
    if gyro is None or found is None:
        return {}
    growing = 0.0 if pose is None else _growing(imu, pose, *found)
    told: tuple[Line, ...] = found if growing == 0 else found[:1] if growing > 0 else found[1:]
    out = {"gyro": told}
    accel = beats["accel"]
    if accel is not None and _beats(accel, told[0][0], rate):
        out["accel"] = tuple((f, phase(accel, f)) for f, _ in told)  # too noisy for the falls to tell more
    return out


def _beats(beat: Beat, frequency: float, rate: float) -> bool:
    """Return whether a triple has a line at a known frequency in Hz, beyond chance."""
    power = np.abs(np.fft.rfft(beat.product)) ** 2
    usual = float(np.median(power[np.fft.rfftfreq(beat.time.size, 1 / rate) > MOTION * rate]))
    seen = abs(np.sum(beat.product * np.exp(-2j * np.pi * frequency * beat.time))) ** 2
    return bool(seen * np.log(2) > usual * np.log(1 / STATISTICS.false_alarms_per_recording))


def _growing(imu: Imu, pose: Pose, one: Line, mirror: Line) -> float:
    """Return 1 where a measured attitude says that ages are those of one line, -1 of its mirror, 0 if it cannot tell.

    Both leave the same alternation o, and the opposite e of what is slower. Without o a gyroscope reads x - e x' or
    x + e x', and the attitude's rate x: what the two differ by, less what is linear in x and x', goes with e x' or
    against it, second by second.
    """
    if pose.quaternion is None:
        return 0.0
    try:
        late, since = gyro_delay(imu, pose.time, pose.quaternion)[0], imu.time - imu.time[0]
    except InputError:  # too little is in view
        return 0.0
    step = max(1, round(1 / (60 * float(np.median(np.diff(pose.time))))))
    start, end, rate = optical_rate(pose.time + late, pose.quaternion, step)
    inside = (start > imu.time[0]) & (end < imu.time[-1])
    start, end, rate = start[inside], end[inside], rate[inside]
    slope = slope_of(imu.gyro, 1 / float(np.median(np.diff(imu.time))))
    same = aged_by(since, (one, mirror))[:, None] * slope
    other = aged_by(since, (one,))[:, None] * slope - same

    def mean(x: Array) -> Array:
        turned = CubicSpline(imu.time, x).antiderivative()
        return np.asarray((turned(end) - turned(start)) / (end - start)[:, None])

    known = np.column_stack([rate, mean(slope), np.ones(len(rate))])
    if len(known) < LEAST:
        return 0.0
    gyro, signal = (y - known @ np.linalg.lstsq(known, y, rcond=None)[0] for y in (mean(imu.gyro + same), mean(other)))
    seconds = np.bincount((start - start[0]).astype(int), np.sum(gyro * signal, axis=1))
    spread = float(np.sqrt(np.sum(seconds**2)))
    z = -float(np.sum(seconds)) / spread if spread > 0 else 0.0
    return float(np.sign(z)) if abs(z) > STATISTICS.interval_sigmas else 0.0  # the wrong way doubles it


__all__ = ["of_one_age"]
