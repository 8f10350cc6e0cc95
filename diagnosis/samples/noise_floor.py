"""How noisy a sensor is, where a hand does not reach: the spectrum above 12 Hz, and the moments at rest.

A person's motion ends near 10 Hz and white noise does not. Each window's power density above 12 Hz, summed over the
axes, is a chi-square of six degrees at every frequency; the median over a band's frequencies passes by lines, its lower
quartile over the windows by bursts of motion, knocks and clips, and of the bands the quietest counts: whatever is not
noise only adds. It is called white if two of the other three bands say the same; what is left of a motion falls with
the square of the frequency or faster, and its bands differ. And noise is there all the time: from the calmest windows
to those the level is read from it changes no more than chance lets it, by a factor of 1.25.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from scipy.signal.windows import blackmanharris
from scipy.stats import gamma

from imubench.arrays import Array
from imubench.diagnosis.config.samples import NOISE_FLOOR, QUIET_MOMENTS
from imubench.diagnosis.samples.even_grid import Stretch
from imubench.diagnosis.samples.sample_faults import Mask

MEDIAN_OVER_MEAN = float(gamma.ppf(0.5, 3, scale=1 / 3))  # of white noise's mean power on three axes, over its mean


@dataclass(frozen=True)
class Level:
    """White noise of one triple."""

    std: float  # per sample
    error: float  # one standard deviation of `std`
    white: bool  # as far as the bands above 12 Hz tell; else `std` is an upper bound


def windows(stretch: Stretch, width: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the first samples of a stretch's windows, overlapping by half."""
    return np.arange(0, stretch.time.size - width + 1, max(1, width // 2))


def densities(stretches: tuple[Stretch, ...], part: str, width: int, skip: Mask) -> tuple[Array, Array]:
    """Return power densities (windows, frequencies) in (unit per sample)^2, mean of the axes, and each one's time.

    White noise of std s has s^2 everywhere. A window with a sample of `skip` (n,) in it is left out.
    """
    taper = blackmanharris(width, sym=False)
    taper /= np.sqrt(np.sum(taper**2))
    rows, times = [], []
    for stretch in stretches:
        x = stretch.part(part)
        for first in windows(stretch, width):
            inside = slice(first, first + width)
            if not skip[stretch.source[inside]].any():
                piece = x[inside] - x[inside].mean(axis=0)
                rows.append(np.mean(np.abs(np.fft.rfft(piece * taper[:, None], axis=0)) ** 2, axis=1))
                times.append(float(stretch.time[first + width // 2]))
    return np.array(rows).reshape(len(rows), width // 2 + 1), np.array(times)


@cache
def noise_bandwidth() -> float:
    """Return the noise bandwidth of a window in bins, of any length: neighbours in frequency are that much alike."""
    taper = blackmanharris(64, sym=False)
    return float(np.mean(taper**2) / np.mean(taper) ** 2)


def white_level(stretches: tuple[Stretch, ...], part: str, rate: float, skip: Mask) -> Level | None:
    """Return the white noise of a triple; None where the recording is too short or sampled too slowly."""
    width = 2 * round(NOISE_FLOOR.window_s * rate / 2)
    nyquist = rate / 2
    if NOISE_FLOOR.most_of_nyquist * nyquist < 1.3 * NOISE_FLOOR.least_hz:
        return None
    power, _ = densities(stretches, part, width, skip)
    if len(power) < NOISE_FLOOR.windows:
        return None
    frequency = np.fft.rfftfreq(width, 1 / rate)
    edges = np.linspace(NOISE_FLOOR.least_hz, NOISE_FLOOR.most_of_nyquist * nyquist, NOISE_FLOOR.bands + 1)
    inside = [(frequency >= a) & (frequency < b) for a, b in pairwise(edges)]
    found = np.array([_floor(power[:, i]) for i in inside])
    order = np.argsort(found)
    quiet, third = found[order[0]], found[order[2]]
    even = found <= NOISE_FLOOR.flat_power * quiet
    if even.sum() < 3:
        even = found == quiet
    use = np.any([i for i, e in zip(inside, even, strict=True) if e], axis=0)
    level = _floor(power[:, use])
    # lower quartile, median and overlap: 2.2 times the variance of a mean, by simulation of 10 to 60 s at 50 to 200 Hz
    free = 3 * len(power) * int(use.sum()) / noise_bandwidth()
    error = np.sqrt(2.2 / free) / 2 + 0.01 * np.sqrt(NOISE_FLOOR.windows / len(power))
    steady = wandering(power[:, use]) < NOISE_FLOOR.steady_power
    return Level(
        float(np.sqrt(level)), float(np.sqrt(level) * error), bool(third <= NOISE_FLOOR.flat_power * quiet) and steady
    )


def wandering(power: Array) -> float:
    """Return by what factor power (windows, frequencies) grows from the calmest windows to where the level is read."""
    each, shape = _each(power)
    calm, level = np.quantile(each, [NOISE_FLOOR.calm_share, NOISE_FLOOR.quartile]) / gamma.ppf(
        [NOISE_FLOOR.calm_share, NOISE_FLOOR.quartile], shape, scale=1 / shape
    )
    return float(level / max(calm, 1e-300))


def _floor(power: Array) -> float:
    """Return the level of noise of power (windows, frequencies): median over frequency, quartile over time."""
    each, shape = _each(power)
    return float(np.quantile(each, NOISE_FLOOR.quartile) / gamma.ppf(NOISE_FLOOR.quartile, shape, scale=1 / shape))


def _each(power: Array) -> tuple[Array, float]:
    """Return each window's level (windows,), a median over frequency, and the shape of the gamma that it follows."""
    each = np.median(power, axis=1) / MEDIAN_OVER_MEAN
    return each, 3 * power.shape[1] / noise_bandwidth() / 1.6  # a median's variance is about 1.6 times a mean's


@dataclass(frozen=True)
class Rest:
    """What a sensor does while it lies still."""

    windows: tuple[tuple[float, float], ...]  # s
    samples: int
    std: dict[str, float]  # of "gyro" and "accel" per sample, about each window's mean
    colour: dict[str, float]  # correlation of neighbouring samples, 0 for white noise


def rests(stretches: tuple[Stretch, ...], rate: float, noise: dict[str, float], n: int) -> tuple[Rest, Mask]:
    """Return the moments at rest, and which samples (n,) lie in them.

    A half-second piece is at rest if neither triple's variance exceeds 2.5 times its white noise's power and the
    mean rate is that of the calmest pieces; a rest is a second of such pieces or more.
    """
    width = max(8, round(QUIET_MOMENTS.window_s * rate))
    pieces = [(s, first) for s in stretches for first in range(0, s.time.size - width + 1, width)]
    mask = np.zeros(n, dtype=bool)
    empty = Rest((), 0, {}, {})
    if not pieces or not noise:
        return empty, mask
    calm = np.ones(len(pieces), dtype=bool)
    for part, std in noise.items():
        spread = np.array([np.var(s.part(part)[i : i + width], axis=0, ddof=1).mean() for s, i in pieces])
        calm &= spread <= NOISE_FLOOR.rest_power * std**2 + 1e-20
    if not calm.any():
        return empty, mask
    rate_mean = np.array([s.gyro[i : i + width].mean(axis=0) for s, i in pieces])
    calm &= np.linalg.norm(rate_mean - np.median(rate_mean[calm], axis=0), axis=1) < NOISE_FLOOR.rest_rad_s
    spans: list[list[tuple[Stretch, int]]] = []
    for (s, i), good in zip(pieces, calm, strict=True):
        if good and spans and spans[-1][-1][0] is s and spans[-1][-1][1] == i - width:
            spans[-1].append((s, i))
        elif good:
            spans.append([(s, i)])
    spans = [span for span in spans if len(span) * width >= NOISE_FLOOR.least_rest_s * rate]
    if not spans:
        return empty, mask
    levels: dict[str, float] = {}
    colour: dict[str, float] = {}
    for part in ("gyro", "accel"):
        x = [span[0][0].part(part)[span[0][1] : span[-1][1] + width] for span in spans]
        left = [piece - piece.mean(axis=0) for piece in x]
        free = sum(len(piece) - 1 for piece in left)
        variance = sum(float((piece**2).sum()) for piece in left) / (3 * free)
        along = sum(float((piece[1:] * piece[:-1]).sum()) for piece in left) / (3 * free)
        levels[part] = float(np.sqrt(variance))
        colour[part] = along / variance if variance > 0 else 0.0
    for span in spans:
        mask[span[0][0].source[span[0][1] : span[-1][1] + width]] = True
    times = tuple(
        (float(span[0][0].time[span[0][1]]), float(span[-1][0].time[span[-1][1] + width - 1])) for span in spans
    )
    return Rest(times, sum(len(span) * width for span in spans), levels, colour), mask
