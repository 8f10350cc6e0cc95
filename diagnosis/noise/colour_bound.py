"""How coloured the noise may be: what may be there without being a mismatch, and what residuals leave of that.

Coloured noise is of first order: beside white noise of power 1 its power at a frequency f is a L(f), with

    L(f) = 1 / (pi step c) / (1 + (f / c)^2),    share of the white noise's power a <= colour, corner c >= slowest_hz

A drift takes what noise there is in its own band, so the residuals do not show it there. What such noise has above
that band no drift takes: there the residuals say, for every corner, how large `a` may be.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.noise import COLOUR
from imubench.diagnosis.config.shared import DECLARED_NOISE, STATISTICS
from imubench.diagnosis.noise.coloured import Spectra
from imubench.diagnosis.problem.averaging import Averaging

CORNERS_HZ = COLOUR.slowest_hz * 2.0 ** np.arange(
    0, 5.5, 0.5
)  # Hz; noise quicker than the last is louder than the white nowhere


def louder_where(
    signals: Sequence[tuple[str, Array, Array]],
    shown: Mapping[str, Spectra],
    above: Mapping[str, Spectra],
    averaging: Averaging,
) -> float:
    """Return that for whitened signals (n m, k) of groups of rows at times (n,).

    `shown`: what residuals show where the signals are; `above`: what counts of it above a drift's band alone;
    `averaging`: of the fit's samples. At most the loudest noise that may be there.
    """
    over = under = 0.0
    loudest = 1.0  # where a signal has no power to tell
    for name, time, signal in signals:
        n = len(time)
        step = float(np.median(np.diff(time)))
        own = averaging.step(name, step)
        use = np.sum(np.abs(np.fft.rfft(signal.reshape(n, -1), axis=0)) ** 2, axis=1)
        may = shares(above.get(name), frequencies(n, step), own)[:, None]
        louder = 1 + np.max(may * powers(frequencies(n, step), own), axis=0)
        loudest = max(loudest, float(louder.max()))
        if name in shown:
            louder = np.minimum(np.maximum(shown[name].at(len(louder)), 1.0), louder)
        over += float(np.sum(use * louder))
        under += float(np.sum(use))
    return max(over / under, 1.0) if under > 0 else loudest


def frequencies(samples: int, step: float) -> Array:
    """Return the frequencies (bins,) Hz of the transform of so many samples every `step` s."""
    return np.asarray(np.fft.rfftfreq(samples, step), dtype=float)


def powers(f: Array, step: float) -> Array:
    """Return L (corners, n) at frequencies f (n,) Hz, of samples every `step` s."""
    corner = CORNERS_HZ[:, None]
    return np.asarray(1 / (np.pi * step * corner) / (1 + (f / corner) ** 2))


def shares(shown: Spectra | None, f: Array, step: float) -> Array:
    """Return the share (corners,) of the white noise's power that coloured noise of each corner may have at most.

    Of the recording's samples, every `step` s; `f` (bins,) Hz are the frequencies of `shown`.

    The bands' powers less the white one's, over L, weighted by what chance lets each be off; and
    `STATISTICS.band_sigmas` times the chance of that.
    """
    most = np.full(len(CORNERS_HZ), DECLARED_NOISE.colour)
    if shown is None:
        return most
    bands = [(int(low), int(high)) for low, high in pairwise(shown.edges)]
    told = [i for i, (low, _) in enumerate(bands) if f[low] >= COLOUR.slowest_hz and shown.seen[i] > COLOUR.least_left]
    if not told:
        return most
    quick = [i for i in told if f[bands[i][0]] >= COLOUR.white_hz]
    white = min(1.0, float(np.min(shown.power[quick]))) if quick else 1.0
    expected = np.stack([powers(f[low:high], step).mean(axis=1) for low, high in (bands[i] for i in told)], axis=1)
    counts = np.array([3 * (bands[i][1] - bands[i][0]) * shown.seen[i] for i in told])
    power = shown.power[told] / white
    chance = np.maximum(power, 1.0) * np.sqrt((1 + 1 / COLOUR.draws) / counts)
    weight = expected / chance**2
    known = np.sum(weight * expected, axis=1)
    found = weight @ (power - 1) / known
    return np.asarray(
        np.clip(np.maximum(found, 0.0) + STATISTICS.band_sigmas / np.sqrt(known), 0.0, DECLARED_NOISE.colour)
    )


__all__ = ["COLOUR", "louder_where", "powers", "shares"]
