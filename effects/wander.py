"""How far the phase of a hum wanders, read off the samples.

A hum A sin(2 pi f t + psi) whose phase psi is a random walk of intensity D rad per root second has, over T seconds, a
straight phase that is off by a slope of variance 6/5 D^2 / T. In windows of `WINDOW` s, z is the mean of the samples
times exp(-i 2 pi f t) and a Hann window h, turned so that its mean is real. Noise enters Re z and Im z alike, the walk
only Im z: between windows next to one another the mean square of what is gained differs by D^2 (W - E|s - s'|) |z|^2, s
and s' drawn from h.
"""

import numpy as np

from imubench.arrays import Array

WINDOW = 1.0  # s
FEWEST = 6  # windows
SURE = 3.2  # times noise's share, from which a walk is seen: one chance in twenty at 15 windows


def frequency_error(time: Array, hum: Array, frequency: float) -> float:
    """Return the standard deviation in Hz that a wandering phase gives the frequency of a hum (n,) at times (n,) s."""
    count = int((time[-1] - time[0]) / WINDOW)
    if count < FEWEST:
        return 0.0
    place = (time - time[0]) / WINDOW
    window = np.minimum(place.astype(int), count - 1)
    h = np.where(place < count, 1 - np.cos(2 * np.pi * (place - window)), 0.0)
    turning = hum * h * np.exp(-2j * np.pi * frequency * (time - time[0]))
    weight = np.bincount(window, h, count)
    if not (weight > 0).all():
        return 0.0
    z = (np.bincount(window, turning.real, count) + 1j * np.bincount(window, turning.imag, count)) / weight
    if not abs(z.mean()) > 0:
        return 0.0
    gained = np.diff(z / z.mean())
    along, across = float(np.mean(gained.real**2)), float(np.mean(gained.imag**2))
    if across < SURE * along:
        return 0.0
    walk = (across - along) / (WINDOW - _apart())
    return float(np.sqrt(1.2 * walk / (time[-1] - time[0])) / (2 * np.pi))


def _apart() -> float:
    """Return the mean distance in s of two times drawn from the window."""
    s = (np.arange(1000) + 0.5) / 1000
    below = np.cumsum(1 - np.cos(2 * np.pi * s)) / 1000
    return float(2 * WINDOW * np.mean(below * (1 - below)))


__all__ = ["frequency_error"]
