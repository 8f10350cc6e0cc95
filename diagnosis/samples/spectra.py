"""Power over frequency of samples that may have gaps."""

from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.samples import TONE


def runs(time: Array) -> list[slice]:
    """Return the stretches of sample times (n,) without a gap, a gap being over 2.5 median steps."""
    if time.size < 3:
        return [slice(0, time.size)]
    step = np.diff(time)
    breaks = np.flatnonzero(step > 2.5 * np.median(step)) + 1
    edges = [0, *breaks.tolist(), time.size]
    return [slice(a, b) for a, b in pairwise(edges)]


def spectrum(time: Array, values: Array, seconds: float = TONE.window_s) -> tuple[Array, Array]:
    """Return frequencies (f,) Hz and one-sided power densities (f, k) of values (n, k), unit^2 / Hz.

    Welch's mean over Hann windows of about `seconds` that overlap by half, the last one up to the end, gaps left out:
    white noise of std 1 has 2 / rate at every frequency. Recordings without a long enough stretch are taken as one.
    """
    step = float(np.median(np.diff(time)))
    width = max(8, min(round(seconds / step), time.size))
    starts = [
        np.unique(np.append(np.arange(run.start, run.stop - width, max(1, width // 2)), run.stop - width))
        for run in runs(time)
        if run.stop - run.start >= width
    ]
    first = np.concatenate(starts) if starts else np.array([0])
    width = min(width, time.size)
    window = np.hanning(width + 2)[1:-1]
    total = np.zeros((width // 2 + 1, values.shape[1]))
    for start in first:
        total += np.abs(np.fft.rfft(window[:, None] * values[start : start + width], axis=0)) ** 2
    total *= 2 * step / (len(first) * np.sum(window**2))
    total[0] /= 2
    if width % 2 == 0:
        total[-1] /= 2
    return np.asarray(np.fft.rfftfreq(width, step)), total
