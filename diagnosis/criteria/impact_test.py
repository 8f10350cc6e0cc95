"""What no motion explains of some samples: the fit is solved with them in it, and beside other samples without them.

With n more numbers its negative log likelihood J rises by about n / 2, minus the part that the motion follows; Q = 2 (J
with - J without) / n is the power per number that no motion explains, summed over every row within
`IMPACT_TEST.beside_s` of a stretch.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import IMPACT_TEST
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.noise.masking import with_mask
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART
from imubench.diagnosis.windows import Window, covered

Mask = NDArray[np.bool_]


def knocks(fit: Fit, imu: str, struck: Mask, peaks: Sequence[Window], together: bool = False) -> Array:
    """Return when the peaks (s) that no motion explains begin; `together` all or none of them, by what they are in sum.

    The fit has not seen the samples `struck` (n,) of that IMU.
    """
    time, known = fit.model.recording.imu(imu).time, counted(fit, imu)
    others = elsewhere(time, np.logical_and.reduce([*known.values()]), peaks)
    if len(others) < IMPACT_TEST.least_others:
        return np.array([])
    left_out = ~covered(time, others)
    without = solved(fit, {name: mask & left_out for name, mask in known.items()})
    if any(power > chance(IMPACT_TEST.others_alarm, n) for power, n in (unexplained(without, fit, p) for p in others)):
        return np.array([])
    with_peaks = solved(fit, {name: mask | struck for name, mask in known.items()})
    found = np.array([unexplained(fit, with_peaks, p) for p in peaks])
    if together:
        power, count = float(found[:, 0] @ found[:, 1]), float(found[:, 1].sum())
        return np.array([a for a, _ in peaks] if power > count * chance(STATISTICS.false_alarm_of_one, count) else [])
    return np.array(
        [a for (a, _), (power, n) in zip(peaks, found, strict=True) if power > chance(STATISTICS.false_alarm_of_one, n)]
    )


def counted(fit: Fit, imu: str) -> dict[str, Mask]:
    """Return which samples (n,) of an IMU are in the fit, by group ("imu1.gyro")."""
    everything = np.ones(fit.model.recording.imu(imu).time.size, dtype=bool)
    return {f"{imu}.{part}": (fit.model.masks or {}).get(f"{imu}.{part}", everything) for part in UNIT_OF_PART}


def chance(alarm: float, count: float) -> float:
    """Return the Q that noise exceeds with a probability of `alarm`, of so many numbers."""
    return float(chi2.isf(alarm, count) / count)


def solved(fit: Fit, masks: Mapping[str, Mask]) -> Fit:
    """Return the fit on other samples, noise levels as they are."""
    return with_mask(fit, {**(fit.model.masks or {}), **masks})


def unexplained(without: Fit, with_it: Fit, window: Window) -> tuple[float, float]:
    """Return Q of a stretch (s) that one fit has and the other has not, and how many numbers are in it."""
    (few, less), (many, more) = (within(fit, window) for fit in (without, with_it))
    count = max(many - few, 1)
    return 2 * (more - less) / count, float(count)


def within(fit: Fit, window: Window) -> tuple[int, float]:
    """Return how many measured numbers are near a stretch (s), and the cost of all rows there."""
    start, end = (t - fit.model.start for t in window)
    count, cost = 0, 0.0
    for rows in fit.rows:
        near = (rows.time >= start - IMPACT_TEST.beside_s) & (rows.time <= end + IMPACT_TEST.beside_s)
        if len(rows.time) == len(rows.residual.value) and near.any():
            cost += 0.5 * float(np.sum(rows.whitened.reshape(len(near), -1)[near] ** 2))
            count += int(near.sum()) * rows.residual.value.shape[1] if rows.counts else 0
    return count, cost


def elsewhere(time: Array, counts: Mask, peaks: Sequence[Window]) -> list[Window]:
    """Return stretches as long as the peaks, at random, of samples that count (n,) and lie apart."""
    rng = np.random.default_rng(STATISTICS.seed)
    lengths = [b - a for a, b in peaks]
    out: list[Window] = []
    for _ in range(10 * IMPACT_TEST.others):
        start = float(rng.uniform(time[0] + 2 * IMPACT_TEST.beside_s, time[-1] - 2 * IMPACT_TEST.beside_s))
        window = (start, start + float(rng.choice(lengths)))
        inside = (time >= window[0] - IMPACT_TEST.beside_s) & (time <= window[1] + IMPACT_TEST.beside_s)
        apart = all(abs(start - a) > 4 * IMPACT_TEST.beside_s for a, _ in out)
        if counts[inside].all() and apart and len(out) < IMPACT_TEST.others:
            out.append(window)
    return out


__all__ = ["counted", "elsewhere", "knocks", "solved"]
