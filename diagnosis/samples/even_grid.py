"""One IMU's samples on an even grid: what is missing filled in so that it adds nothing at high frequencies.

The missing values of a stretch are those that make the sum of squares of its sixth differences least; for a
10 Hz motion sampled at 100 Hz a single one is off by (2 sin(pi/10))^12 / C(12, 6) = 3e-6 of the motion. So a
gap never looks like a knock or like noise.
"""

from dataclasses import dataclass
from math import comb

import numpy as np
from scipy.sparse import csc_matrix, diags_array
from scipy.sparse.linalg import spsolve

from imubench.arrays import Array
from imubench.diagnosis.config.samples import SCREENING
from imubench.diagnosis.samples.sample_faults import Mask


@dataclass(frozen=True)
class Stretch:
    """Samples at an even interval without a long gap."""

    time: Array  # (m,) s
    gyro: Array  # (m, 3)
    accel: Array  # (m, 3)
    filled: Mask  # (m,) not measured
    source: np.ndarray[tuple[int], np.dtype[np.int64]]  # (m,) row of the recording, the last one before where filled

    def part(self, name: str) -> Array:
        """Return the values (m, 3) of "gyro" or "accel"."""
        return self.gyro if name == "gyro" else self.accel


def stretches(time: Array, gyro: Array, accel: Array, bad: Mask) -> tuple[Stretch, ...]:
    """Return the stretches of a recording whose samples marked `bad` (n,) or missing are filled in."""
    good = np.flatnonzero(~bad)
    if good.size < 2:
        return ()
    usual = float(np.median(np.diff(time)))
    slot = np.concatenate([[0], np.cumsum(np.maximum(1, np.round(np.diff(time) / usual)).astype(int))])[good]
    ends = np.flatnonzero(np.diff(slot) > SCREENING.resampling_degree + 1) + 1
    both = np.hstack([gyro, accel])
    out = []
    for rows, slots in zip(np.split(good, ends), np.split(slot, ends), strict=True):
        if rows.size < 2 * SCREENING.resampling_degree:
            continue
        at = slots - slots[0]
        m = int(at[-1]) + 1
        filled = np.ones(m, dtype=bool)
        filled[at] = False
        values = np.zeros((m, both.shape[1]))
        values[at] = both[rows]
        values = smooth_fill(values, filled)
        stamps = np.interp(np.arange(m), at, time[rows])
        source = rows[np.cumsum(~filled) - 1]
        out.append(Stretch(stamps, values[:, :3], values[:, 3:], filled, source))
    return tuple(out)


def smooth_fill(values: Array, filled: Mask) -> Array:
    """Return values (m, k) with the rows `filled` (m,) such that the sixth differences are least."""
    unknown = np.flatnonzero(filled)
    if not unknown.size:
        return values
    m = len(values)
    weights = [float((-1) ** j * comb(SCREENING.resampling_degree, j)) for j in range(SCREENING.resampling_degree + 1)]
    difference = csc_matrix(
        diags_array(weights, offsets=range(SCREENING.resampling_degree + 1), shape=(m - SCREENING.resampling_degree, m))
    )
    known = np.where(filled[:, None], 0.0, values)
    out = known.copy()
    part = difference[:, unknown]
    solution = spsolve(csc_matrix(part.T @ part), -(part.T @ (difference @ known)))
    out[unknown] = np.asarray(solution).reshape(unknown.size, -1)
    return out
