"""Where residuals exceed the noise: sensor, channels, bands, windows, and what the excess goes with."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.residuals import LOCALIZE
from imubench.diagnosis.config.samples import TONE
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.evidence import Trace, of_sensor
from imubench.diagnosis.result import Pair, Where
from imubench.diagnosis.samples.spectra import spectrum

NOTHING = "nothing clear"

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Regressors:
    """What a sensor's segment did: magnitudes (n,) by name, at times (n,) s of the sensor's clock."""

    time: Array
    values: Mapping[str, Array]


def shares(power: Mapping[str, float]) -> dict[str, float]:
    """Return each channel's share of the power, the largest first and without the small ones."""
    total = sum(power.values())
    return {
        name: float(p / total) for name, p in sorted(power.items(), key=lambda x: -x[1]) if p > LOCALIZE.small * total
    }


def locate(traces: Sequence[Trace], motion: Mapping[str, Regressors], noise: float = 1.0) -> tuple[Where, ...]:
    """Return where residuals, or what findings add to a simulation, exceed the noise; the largest share first.

    Args:
        traces: by triple of a sensor.
        motion: the regressors of each sensor; one without any is said to go with nothing.
        noise: power of the noise in the whitened traces: 1 of residuals, 0 of the difference of two simulations.

    Returns:
        One for each sensor.
    """
    excess = {trace.name: channel_excess(trace.whitened, noise) for trace in traces}
    total = sum(float(e.sum()) for e in excess.values())
    if total <= 0:
        return ()
    found = []
    for at, parts in of_sensor(traces).items():
        shares = {
            channel: float(e) / total
            for trace in parts
            for channel, e in zip(trace.channels, excess[trace.name], strict=True)
        }
        share = sum(shares.values())
        if share < LOCALIZE.small:
            continue
        named = {c: s for c, s in sorted(shares.items(), key=lambda item: -item[1]) if s >= LOCALIZE.small}
        named = named or {max(shares, key=lambda c: shares[c]): max(shares.values())}
        loud = [(t.time, t.whitened[:, [c in named for c in t.channels]]) for t in parts]
        loud = [(time, z) for time, z in loud if z.shape[1]]
        goes_with = depends_on(loud, motion[at], noise) if at in motion else NOTHING
        found.append(Where(at, named, bands(loud, noise), windows(loud, noise), goes_with, min(share, 1.0)))
    return tuple(sorted(found, key=lambda w: -w.share))


def acting_in(added: Sequence[Where], left: Sequence[Where]) -> tuple[Where, ...]:
    """Return where findings act, with the bands and windows of what a declared model leaves of these sensors, if any.

    Which sensor and which channels are at fault shows in what the findings add to a simulation. What a motion cannot
    follow of that, as a resonance, shows in the residuals: a spring's sag, which it can, would hide it in the added.

    Args:
        added: located in the difference of two simulations.
        left: located in the residuals of the declared model.
    """
    known = {w.at: w for w in left}
    told = (known.get(w.at, w) for w in added)
    return tuple(
        replace(w, bands_hz=own.bands_hz, windows_s=own.windows_s, depends_on=own.depends_on)
        for w, own in zip(added, told, strict=True)
    )


def channel_excess(z: Array, noise: float = 1.0) -> Array:
    """Return the power (k,) of whitened signals (n, k) above their noise; zero where it is within its scatter."""
    over = np.sum(z**2 - noise, axis=0)
    return np.where(over > STATISTICS.clear_sigmas * noise * np.sqrt(2 * len(z)), over, 0.0)


Loud = Sequence[tuple[Array, Array]]
"""Times (n,) and whitened residuals (n, k) of the channels that hold the excess, per triple."""


def local_excess(loud: Loud, width: float, noise: float = 1.0) -> tuple[Array, Array, Array]:
    """Return the edges (m + 1,) s of bins, the excess power in each, and how many numbers it is made of."""
    start, end = min(t[0] for t, _ in loud), max(t[-1] for t, _ in loud)
    count = max(1, int(np.ceil((end - start) / width)))
    edges = start + width * np.arange(count + 1)
    over, numbers = np.zeros(count), np.zeros(count)
    for time, z in loud:
        at = np.minimum(((time - start) / width).astype(int), count - 1)
        over += np.bincount(at, np.sum(z**2 - noise, axis=1), count)
        numbers += np.bincount(at, minlength=count) * z.shape[1]
    edges[-1] = end
    return edges, over, numbers


def windows(loud: Loud, noise: float = 1.0) -> tuple[Pair, ...]:
    """Return the windows in s that hold most of the excess; one over everything where it is nearly everywhere."""
    edges, over, numbers = local_excess(loud, LOCALIZE.bin_s, noise)
    chosen = smallest_set(np.where(over > STATISTICS.clear_sigmas * noise * np.sqrt(2 * numbers), over, 0.0))
    return spans(edges, chosen, over, LOCALIZE.windows, near=2)


def bands(loud: Loud, noise: float = 1.0) -> tuple[Pair, ...]:
    """Return the bands in Hz that hold most of the excess, the sensor's channels taken together."""
    spectra = []
    for time, z in loud:
        f, density = spectrum(time, z)
        white = noise * 2 * float(np.median(np.diff(time)))
        averages = max(1.0, 2 * (time[-1] - time[0]) / TONE.window_s - 1)
        surplus = np.sum(density - white, axis=1)
        seen = surplus > STATISTICS.clear_sigmas * white * np.sqrt(z.shape[1] / averages)
        spectra.append((f, np.where(seen | (not seen.any()), surplus, 0.0)))
    frequency = max((f for f, _ in spectra), key=len)
    over = np.sum([np.interp(frequency, f, s, right=0.0) for f, s in spectra], axis=0)
    step = frequency[1] - frequency[0]
    edges = np.append(np.maximum(frequency - step / 2, 0.0), frequency[-1])
    return spans(edges, smallest_set(over), over, LOCALIZE.bands, near=2)


def smallest_set(over: Array) -> Mask:
    """Return the fewest bins (m,) that hold most of the excess, and with them those that are not much weaker."""
    over = np.maximum(over, 0.0)
    order = np.argsort(-over)
    held = np.cumsum(over[order])
    chosen = np.zeros(len(over), dtype=bool)
    if held[-1] > 0:
        most = order[: int(np.searchsorted(held, LOCALIZE.most * held[-1])) + 1]
        chosen = over >= LOCALIZE.weak * over[most].mean()
        chosen[most] = True
    return chosen


def spans(edges: Array, chosen: Mask, over: Array, most: int, near: int) -> tuple[Pair, ...]:
    """Return the stretches of chosen bins, those at most `near` bins apart taken as one, at most `most` of them.

    Stretches that hold little are left out, unless all do.
    """
    if not chosen.any():
        return ()
    steps = np.diff(np.concatenate([[0], chosen.astype(int), [0]]))
    first, last = np.flatnonzero(steps > 0), np.flatnonzero(steps < 0)  # bins first..last - 1
    apart = first[1:] - last[:-1]
    widest = np.sort(apart)[::-1][most - 1] if len(apart) >= most else 0
    kept = apart > max(near, widest)
    first, last = first[np.append(True, kept)], last[np.append(kept, True)]
    if np.sum(last - first) >= LOCALIZE.whole * len(over):
        return (_rounded(edges[0], edges[-1]),)
    held = np.array([np.maximum(over[a:b], 0.0).sum() for a, b in zip(first, last, strict=True)])
    large = held >= LOCALIZE.small * held.sum() if (held >= LOCALIZE.small * held.sum()).any() else held == held.max()
    return tuple(_rounded(edges[a], edges[b]) for a, b in zip(first[large], last[large], strict=True))


def _rounded(low: float, high: float) -> Pair:
    return round(float(low), 4) + 0.0, round(float(high), 4) + 0.0  # no -0.0


def depends_on(loud: Loud, motion: Regressors, noise: float = 1.0) -> str:
    """Return the name of the regressor whose local size goes with the local excess, if one clearly does."""
    edges, over, numbers = local_excess(loud, LOCALIZE.local_s, noise)
    full = numbers > 0.5 * np.median(numbers)
    size = np.sqrt(np.maximum(over / np.maximum(numbers, 1), 0.0))[full]
    size = np.minimum(size, np.quantile(size, 0.99))
    found = sorted(
        ((correlation(size, local_rms(edges, motion.time, x)[full]), name) for name, x in motion.values.items()),
        reverse=True,
    )
    if (
        not found
        or found[0][0] < LOCALIZE.correlation
        or (len(found) > 1 and found[0][0] < found[1][0] + LOCALIZE.lead)
    ):
        return NOTHING
    return found[0][1]


def local_rms(edges: Array, time: Array, values: Array) -> Array:
    """Return the RMS (m,) of values (n,) between the edges (m + 1,), zero where there is none."""
    at = np.searchsorted(edges, time, side="right") - 1
    inside = (at >= 0) & (at < len(edges) - 1)
    count = np.bincount(at[inside], minlength=len(edges) - 1)
    power = np.bincount(at[inside], values[inside] ** 2, len(edges) - 1)
    return np.sqrt(power / np.maximum(count, 1))


def correlation(x: Array, y: Array) -> float:
    """Return Pearson's correlation, 0 where one does not vary."""
    x, y = x - x.mean(), y - y.mean()
    size = float(np.sqrt(np.sum(x**2) * np.sum(y**2)))
    return float(np.sum(x * y)) / size if size > 1e-12 else 0.0
