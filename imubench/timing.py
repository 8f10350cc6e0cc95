"""When an optical record was taken, by the clock of the IMUs that it saw: from how fast both say that things turn.

Gyroscope and optical orientation agree in the norm of the angular rate, whatever the mount and the world's heading.
The optical stamps are late by d where the norms agree best, over all IMUs together:

    | turn of the gyroscope from s - d to e - d |  =  | turn of the optical orientation from s to e |
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline

from imubench.alignment import optical_rate
from imubench.arrays import Array
from imubench.errors import InputError
from imubench.recording import Imu

FARTHEST = 0.5  # s, searched on both sides: devices that a person starts on one signal are closer
COARSE = 0.005  # s between the offsets that are tried first: a tenth of a hand's fastest period and less
SPAN = 0.1  # s over which turns are compared: shorter than a hand's strokes, longer than what a soft mount rocks in
FASTEST = 1e6  # rad/s: a thousand times what any gyroscope reads; the turns of such a one add up to numbers
SHORTEST, LONGEST = 1e-6, 1e5  # s between samples: no IMU gives a million a second, or waits for more than a day
FEWEST = 50  # spans in view of an IMU before it counts
ENOUGH = 2000  # spans of an IMU that the grid is tried on
BLOCK = 4.0  # s; errors of different blocks are taken for independent
TUKEY = 4.685  # robust standard deviations beyond which a span has no weight; 95 % efficient where errors are normal
ROUNDS = 30
TINY = 1e-9  # rad/s, the scatter of noise-free data: keeps their weights finite
STEP = 1e-7  # s, at which the fit ends
SURE = 0.25  # of a frame's period: an offset that is not known better than that is not applied
CONTRAST = 0.8  # of the difference at a usual offset: what may be left at the best one, or nothing was recognised
SIGNIFICANT = 4.0  # standard deviations that a drift has to have before it is applied


@dataclass(frozen=True)
class Timing:
    """How late optical stamps are against the clock of IMUs: `late` at the stamp `middle`, and growing by `drift`."""

    late: float  # s
    std: float  # s
    drift: float  # s per s
    drift_std: float  # s per s
    middle: float  # s, optical stamp
    length: float  # s, from the first span in view to the last
    misfit: float  # rad/s, robust std of what the norms differ by
    apart: float  # s, RMS difference of the IMUs' own offsets from `late`
    contrast: float  # mean difference of the norms near `late`, as a part of that at a usual offset
    imus: int
    period: float  # s between optical frames

    @property
    def known(self) -> bool:
        """Whether the offset is known well enough to be applied."""
        return bool(self.std < SURE * self.period and self.contrast < CONTRAST)

    @property
    def drifts(self) -> bool:
        """Whether the two clocks are seen to run at different speeds, by more than the offset is unsure of."""
        moved = abs(self.drift) * self.length / 2
        return self.known and bool(abs(self.drift) > SIGNIFICANT * self.drift_std and moved > 2.0 * self.std)

    def applied(self, stamps: Array) -> Array:
        """Return optical stamps (n,) s on the IMUs' clock; as they are where the offset is not known."""
        if not self.known:
            return stamps
        return stamps - self.late - (self.drift * (stamps - self.middle) if self.drifts else 0.0)

    def __str__(self) -> str:
        who = f"{self.imus} gyroscope{'s' if self.imus > 1 else ''}"
        late = f"{self.late * 1e3:+.2f} +- {self.std * 1e3:.2f} ms late by {who}"
        if not self.known:
            return f"Optical stamps as written: they are {late}, which is not sure enough to be taken out."
        alone = f", each alone within {self.apart * 1e3:.2f} ms RMS" if self.imus > 1 else ""
        drift = f"{self.drift * 1e6:+.0f} +- {self.drift_std * 1e6:.0f} ppm"
        return (
            f"Optical stamps {late}{alone}: taken out. The clocks drift apart by {drift}: "
            f"{'taken out, too' if self.drifts else 'not significant, left in'}."
        )


@dataclass(frozen=True)
class _Spans:
    """The spans in which one IMU and its optical orientation were both seen."""

    start: Array  # (m,) s, optical stamps
    end: Array  # (m,) s
    speed: Array  # (m,) rad/s, optical
    turned: CubicSpline  # of time: the gyroscope's integral (3,) rad
    first: float  # s, of the IMU's samples
    last: float
    rate: float  # Hz

    def every(self, step: int) -> "_Spans":
        """Return every `step`th span."""
        return replace(self, start=self.start[::step], end=self.end[::step], speed=self.speed[::step])

    def residual(self, late: Array) -> tuple[Array, Array]:
        """Return how much faster the gyroscope turns (m,) in rad/s, NaN without samples, and its slope by `late`."""
        length = self.end - self.start
        ends = self.turned(self.end - late), self.turned(self.start - late)
        mean = (ends[0] - ends[1]) / length[:, None]
        speed = np.linalg.norm(mean, axis=1)
        change = (self.turned(self.end - late, 1) - self.turned(self.start - late, 1)) / length[:, None]
        slope = -np.sum(mean * change, axis=1) / np.maximum(speed, 1e-12)
        inside = (self.start - late >= self.first) & (self.end - late <= self.last)
        return np.where(inside, speed - self.speed, np.nan), slope


def optical_timing(pairs: Sequence[tuple[Imu, Array, Array]]) -> Timing:
    """Return how late optical stamps are, from IMUs each with stamps (n,) s and quaternions (n, 4), NaN where unseen.

    The quaternions turn any frame fixed to the IMU's segment into the world. Least squares with Tukey's weights over
    the spans of all IMUs, each by its own scatter; first the offset alone, then with a drift. The stds are those of a
    sandwich whose blocks of 4 s hold all IMUs. Raises `InputError` when too little is in view.
    """
    spans = [_spans(*pair) for pair in pairs if min(pair[0].time.size, pair[1].size) > 1]
    counts = [one.start.size for one in spans]
    spans = [one for one, count in zip(spans, counts, strict=True) if count >= FEWEST]
    if not spans:
        most = max(counts, default=0)
        raise InputError(f"optical record of {pairs[0][0].name}: expected {FEWEST} frames or more in view, got {most}")
    middle = 0.5 * (min(s.start[0] for s in spans) + max(s.end[-1] for s in spans))
    begin, contrast = _coarse(spans)
    offset, offset_cov, misfit = _fit(spans, np.array([begin]), middle)
    both, both_cov, _ = _fit(spans, np.array([offset[0], 0.0]), middle)
    alone = np.array([_fit([one], np.array([offset[0], 0.0]), middle)[0] for one in spans]) - both
    between = np.mean(alone**2, axis=0)  # mounts that give way let each IMU lead or lag by some ms of its own
    several = between / max(len(spans) - 1, 1)
    return Timing(
        late=float(offset[0]),
        std=float(np.sqrt(offset_cov[0, 0] + several[0])),
        drift=float(both[1]),
        drift_std=float(np.sqrt(both_cov[1, 1] + several[1])),
        middle=float(middle),
        length=float(max(s.end[-1] for s in spans) - min(s.start[0] for s in spans)),
        misfit=misfit,
        apart=float(np.sqrt(between[0])),
        contrast=contrast,
        imus=len(spans),
        period=float(np.median(np.diff(pairs[0][1]))),
    )


def on_imu_clock(
    pairs: Sequence[tuple[Imu, Array, Array]], stamps: Array, given: float | None = None
) -> tuple[Array, str]:
    """Return optical stamps (n,) s on the clock of IMUs, and a sentence on how: as `optical_timing` finds, or as given.

    `given` in s is by how much the stamps are late; 0 leaves them as written.
    """
    timing = optical_timing(pairs)
    if given is None:
        return timing.applied(stamps), str(timing)
    by_data = f"{timing.late * 1e3:+.2f} +- {timing.std * 1e3:.2f} ms"
    return (
        stamps - given,
        f"Optical stamps taken {given * 1e3:g} ms earlier than written, as told; by the data {by_data}.",
    )


def _spans(imu: Imu, time: Array, quaternion: Array) -> _Spans:
    period = float(np.median(np.diff(time)))
    if not period > 0:
        raise InputError(f"optical record of {imu.name}: expected stamps that rise, got a median step of {period:g} s")
    start, end, rate = optical_rate(time, quaternion, max(1, round(SPAN / period)))
    inside = (start > imu.time[0] - FARTHEST) & (end < imu.time[-1] + FARTHEST)
    quickest, steps = float(np.abs(imu.gyro).max()), np.diff(imu.time)
    if not quickest < FASTEST:
        raise InputError(f"{imu.name}: expected rates below {FASTEST:g} rad/s, got {quickest:g} rad/s")
    if not SHORTEST < steps.min() <= steps.max() < LONGEST:
        got = f"{steps.min():g} to {steps.max():g}"
        raise InputError(f"{imu.name}: expected samples {SHORTEST:g} to {LONGEST:g} s apart, got {got} s")
    turned = CubicSpline(imu.time, cumulative_trapezoid(imu.gyro, imu.time, axis=0, initial=0))
    speed = np.linalg.norm(rate[inside], axis=1)
    return _Spans(start[inside], end[inside], speed, turned, float(imu.time[0]), float(imu.time[-1]), imu.rate)


def _coarse(spans: list[_Spans]) -> tuple[float, float]:
    """Return the offset of a grid at which the norms differ least on average, and that as a part of the median."""
    grid = np.arange(-FARTHEST, FARTHEST + COARSE / 2, COARSE)
    total = np.zeros(grid.size)
    for one in spans:
        few = one.every(-(-one.start.size // ENOUGH))
        differences = np.array([np.nanmean(np.abs(few.residual(np.array(late))[0])) for late in grid])
        total += differences / max(float(differences.min()), TINY)
    return float(grid[int(total.argmin())]), float(total.min() / max(np.median(total), TINY))


def _fit(spans: list[_Spans], start: Array, middle: float) -> tuple[Array, Array, float]:
    """Return offset and, where two values are given to start from, drift; their covariance; the scatter in rad/s."""
    x = start.copy()
    for _ in range(ROUNDS):
        hessian, blocks, _ = _normal_equations(spans, x, middle)
        step = np.linalg.solve(hessian, blocks.sum(axis=0))
        x = x - step
        if abs(step[0]) < STEP:
            break
    hessian, blocks, misfit = _normal_equations(spans, x, middle)
    inverse = np.linalg.inv(hessian)
    scores = blocks[np.any(blocks != 0.0, axis=1)]
    return x, inverse @ (scores.T @ scores) @ inverse * len(scores) / max(len(scores) - 1, 1), misfit


def _normal_equations(spans: list[_Spans], x: Array, middle: float) -> tuple[Array, Array, float]:
    """Return J^T W J, J^T W e of each block of time, and the RMS over the IMUs of the robust scatter in rad/s."""
    begin = min(one.start[0] for one in spans)
    count = int((max(one.start[-1] for one in spans) - begin) / BLOCK) + 1
    hessian, blocks, variances = TINY * np.eye(x.size), np.zeros((count, x.size)), []
    for one in spans:
        since = one.start - middle
        error, slope = one.residual(x[0] + (x[1] * since if x.size > 1 else np.zeros(since.size)))
        seen = np.isfinite(error)
        error, slope, since = error[seen], slope[seen], since[seen]
        scatter = max(1.4826 * float(np.median(np.abs(error - np.median(error)))), TINY)
        weight = np.maximum(1.0 - (error / (TUKEY * scatter)) ** 2, 0.0) ** 2 / scatter**2
        rows = np.stack([slope, slope * since][: x.size], axis=1)
        hessian += (rows * weight[:, None]).T @ rows
        np.add.at(blocks, ((one.start[seen] - begin) / BLOCK).astype(int), rows * (weight * error)[:, None])
        variances.append(scatter**2)
    return hessian, blocks, float(np.sqrt(np.mean(variances)))
