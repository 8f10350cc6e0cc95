"""How far the phase of a hum wanders, read off the samples.

A hum A sin(2 pi f t + psi) whose phase psi is a random walk of intensity D rad per root second has, over T seconds, a
straight phase that is off by a slope of variance 6/5 D^2 / T. In windows of `WINDOW` s, z is the mean of the samples
times exp(-i 2 pi f t) and a Hann window, turned so that its mean is real: the phase of a window is Im z / |z|, the
walk's mean there and white noise. D^2 is its mean over all D / noise alike plausible beforehand, weighed by how likely
they make the phases less the straight line that the fit of f has taken out of them; once with the noise as loud in Re
z, and once with Re z left out, for a limit on the samples makes that louder. (By the likeliest D alone two
frequencies in five missed their interval where noise nearly hides the walk, one by 9 standard deviations.) The
covariance of the walk's means in windows i < j is W D^2 (i + 1/2), and in one W D^2 (i + (1 - d) / 2), d the mean
distance of two times drawn from a window, in windows.
"""

import numpy as np

from imubench.arrays import Array

WINDOW = 1.0  # s
FEWEST = 6  # windows
RATIOS = np.logspace(-4, 4, 161)  # of the walk's variance in a window to the noise's


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
    straight, phase = (z / z.mean()).real, (z / z.mean()).imag
    walk = max(_walk(phase, straight[:0]), _walk(phase, straight - straight.mean()))
    return float(np.sqrt(1.2 * walk / (time[-1] - time[0])) / (2 * np.pi))


def _walk(phase: Array, noisy: Array) -> float:
    """Return the mean D^2 in rad^2 / s of windows' phases (n,) in rad.

    `noisy` (m,) has the same noise and no more, m - 1 of it free.
    """
    i = np.arange(len(phase), dtype=float)
    straight = np.linalg.qr(np.stack([np.ones_like(i), i], axis=1), mode="complete")[0][:, 2:]
    walked = np.minimum.outer(i, i) + 0.5 - np.diag(np.full(len(i), 0.5 * _apart()))
    spread, axes = np.linalg.eigh(straight.T @ walked @ straight)
    power = (axes.T @ straight.T @ phase) ** 2
    share = 1 + RATIOS[:, None] * spread
    count = len(power) + max(len(noisy) - 1, 0)
    noise = (np.sum(power / share, axis=1) + np.sum(noisy**2)) / count
    likely = -0.5 * (count * np.log(noise) + np.sum(np.log(share), axis=1))
    weight = np.exp(likely - likely.max())
    return float(np.sum(weight * RATIOS * noise) / weight.sum()) / WINDOW


def _apart() -> float:
    """Return the mean distance, in windows, of two times drawn from one."""
    s = (np.arange(1000) + 0.5) / 1000
    below = np.cumsum(1 - np.cos(2 * np.pi * s)) / 1000
    return float(2 * np.mean(below * (1 - below)))


__all__ = ["frequency_error"]
