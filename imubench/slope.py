"""How fast readings change, and what they have above any motion: both at even stamps."""

import numpy as np
from scipy.signal import butter, sosfiltfilt

from imubench.arrays import Array

MOTION = 0.4  # of the sampling rate, up to which what is read may be motion
LEAST = 60  # samples that a filter needs


def slope_of(x: Array, rate: float) -> Array:
    """Return how fast readings (n, 3) at a rate in Hz change, per s, up to half of what may be motion."""
    sos = butter(4, MOTION, output="sos")  # of half the rate
    slow = sosfiltfilt(sos, x, axis=0) if len(x) >= LEAST else x
    return np.asarray(np.gradient(slow, axis=0) * rate)


def above_motion(x: Array) -> Array:
    """Return what signals (n, 3) have above any motion; n at least `LEAST`."""
    return np.asarray(sosfiltfilt(butter(6, 2 * MOTION, "high", output="sos"), x, axis=0))
