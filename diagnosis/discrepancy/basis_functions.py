"""Functions of a signal that a term may consist of, nothing where the signal is zero."""

import numpy as np
from scipy.interpolate import BSpline
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import HELD_OUT
from imubench.diagnosis.config.discrepancy import BASIS


def curve(x: Array) -> Array:
    """Return the cubic B-splines (n, k) of x (n,) over its range, each less its value at zero."""
    low, high = float(x.min()), float(x.max())
    if high - low < 1e-9:
        return np.zeros((len(x), 0))
    knots = np.linspace(low, high, BASIS.pieces + 1)
    knots = np.concatenate([[low] * 3, knots, [high] * 3])
    basis = BSpline.design_matrix(np.append(np.clip(x, low, high), np.clip(0.0, low, high)), knots, 3).toarray()
    return np.asarray(basis[:-1] - basis[-1])


def kinked(x: Array) -> Array:
    """Return the same and, since a law may break at zero or on either side of it, signs of x rounded over some widths.

    Some gradually, some straight up to a width: what a dead zone takes away.
    """
    return np.concatenate([curve(x), np.stack(signs(x), axis=1)], axis=1) if np.std(x) > 1e-9 else curve(x)


def signs(x: Array) -> list[Array]:
    """Return signs of x (n, ...), each channel's rounded over some shares of its scatter."""
    scatter = np.maximum(np.std(x, axis=0), 1e-9)
    rounded = [np.tanh(x / (share * scatter)) for share in BASIS.kinks]
    return [*rounded, *(np.clip(x / (share * scatter), -1.0, 1.0) for share in BASIS.zones)]


def drifts(time: Array) -> Array:
    """Return smooth functions of time (n, k), zero at the start."""
    seconds = float(time[-1] - time[0])
    pieces = int(np.clip(seconds / (BASIS.drift_piece * min(HELD_OUT.block_s, seconds / HELD_OUT.least_blocks)), 2, 12))
    knots = np.linspace(time[0], time[-1], pieces + 1)
    knots = np.concatenate([[knots[0]] * 3, knots, [knots[-1]] * 3])
    basis = BSpline.design_matrix(time, knots, 3).toarray()
    return np.asarray(basis[:, 1:] - basis[:1, 1:])


def settling(time: Array) -> Array:
    """Return functions of time (n, k) that settle exponentially from the start on, as what creeps or warms up does."""
    late = (time - time[0]) / float(time[-1] - time[0])
    return np.asarray(1 - np.exp(-late[:, None] / np.array(BASIS.settling)))


def play(x: Array, width: Array) -> Array:
    """Return what follows x (n, ..., m) only beyond play of half `width` (..., m): as large as both together."""
    here = x[0] + np.zeros_like(width)
    out = np.empty((len(x), *here.shape))
    for i, value in enumerate(x):  # what comes next depends on where it stood
        here = np.minimum(np.maximum(here, value - width), value + width)
        out[i] = here
    return out


def shaking(x: Array, rate: float) -> Array:
    """Return the power (n, k) of x (n, 3) above `BASIS.shaking_hz`, felt over some times."""
    fast = x - gaussian_filter1d(x, rate / (2 * np.pi * BASIS.shaking_hz) * 1.2, axis=0, mode="nearest")
    power = np.sum(fast**2, axis=1)
    decays = [np.exp(-1 / (s * rate)) for s in BASIS.shaking_s]
    return np.stack([lfilter([1 - d], [1, -d], power, zi=[d * power[0]])[0] for d in decays], axis=1)


def even(*columns: Array) -> Array:
    """Return columns (n, k) of an RMS of 1."""
    x = np.stack(columns, axis=1)
    return np.asarray(x / np.maximum(np.sqrt(np.mean(x**2, axis=0)), 1e-12))
