"""A sensor's noise from the moments at which least happens, where nobody declares it."""

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.samples import QUIET_MOMENTS
from imubench.diagnosis.samples.sample_faults import steps


def quiet_level(time: Array, values: Array, most: float = np.inf) -> float:
    """Return the std of what a parabola leaves of values (n, k) in the quietest tenth of half-second windows.

    An upper bound of the noise: motion that a parabola does not follow counts as noise, up to `most`. At least that of
    the readings' rounding, which shows only while they move: a sensor at rest may read the same for seconds.
    """
    step = steps(values)
    rounding = max(float(np.sqrt(np.mean(step**2) / 12)), QUIET_MOMENTS.finest)
    width = max(QUIET_MOMENTS.samples, round(QUIET_MOMENTS.window_s / float(np.median(np.diff(time)))))
    count = len(time) // width
    if count < 1:
        return max(min(float(np.std(values, axis=0).mean()), most), rounding)
    pieces = values[: count * width].reshape(count, width, -1)
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1, 1, width), 3))
    left = pieces - basis @ (basis.T @ pieces)
    power = np.sum(left**2, axis=(1, 2)) / ((width - 3) * values.shape[1])
    level = float(np.sqrt(np.median(np.sort(power)[: max(1, round(QUIET_MOMENTS.share * count))])))
    return max(min(level, most), rounding)
