"""The map of what differs: every channel over time and over frequency, without and with what was found."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.report import CHART
from imubench.diagnosis.config.residuals import LOCALIZE
from imubench.diagnosis.evidence import Comparison, Evidence, Trace
from imubench.diagnosis.report.words import covers
from imubench.diagnosis.result import Pair, Where
from imubench.diagnosis.samples.spectra import spectrum
from imubench.reproduce.report import escape


@dataclass(frozen=True)
class Series:
    """One channel's difference between measured and simulated, over its noise."""

    at: str
    channel: str
    time: Array  # (n,) s
    before: Array  # (n,) of the declared model
    after: Array | None  # (n,) of the model with what was found; None where nothing was


def of_traces(traces: Sequence[Trace]) -> list[Series]:
    """Return the residuals of a fitted motion by channel."""
    out = []
    for t in traces:
        after = t.whitened_after
        for i, name in enumerate(t.channels):
            out.append(Series(t.at, name, t.time, t.whitened[:, i], None if after is None else after[:, i]))
    return out


def of_simulation(compared: Sequence[Comparison]) -> list[Series]:
    """Return what MuJoCo's simulations differ from the samples by."""
    out = []
    for c in compared:
        at, _, channel = c.channel.partition(".")
        before, after = ((y - c.measured) / c.noise for y in (c.before, c.after))
        out.append(Series(at, channel, c.time, before, after))
    return out


def misfit_map(evidence: Evidence, where: Sequence[Where], found: bool = True) -> str:
    """Return the map as HTML: MuJoCo's simulations where they were played, else the residuals of the fitted motion.

    Args:
        evidence: residuals and simulations.
        where: what is framed in the declared model's map.
        found: whether anything was found that the second map has in it.
    """
    series = of_simulation(evidence.simulated) or of_traces(evidence.traces)
    start, end = evidence.span
    sides = [("The model as declared", [s.before for s in series])]
    if found and any(s.after is not None for s in series):
        after = [s.before if s.after is None else s.after for s in series]
        sides.append(("The model with what was found in it", after))
    parts = []
    for i, (name, values) in enumerate(sides):
        edges, levels = over_time(series, values, (start, end))
        f_edges, f_levels = over_frequency(series, values)
        windows = [(w.at, [p for p in w.windows_s if not covers(p, (start, end))]) for w in where] if i == 0 else []
        bands = [(w.at, w.bands_hz) for w in where] if i == 0 else []
        labels = "".join(f"<span>{escape(f'{s.at} {s.channel}'.replace('_', ' '))}</span>" for s in series)
        parts.append(
            f"<p class='axis'><b>{name}</b></p><div class='map'><div class='rows'>{labels}</div>"
            f"<div>{_cells(edges, levels, _frames(series, windows, edges))}"
            f"{_axis(0.0, end - start, 's')}</div>"
            f"<div>{_cells(f_edges, f_levels, _frames(series, bands, f_edges))}"
            f"{_axis(f_edges[0], f_edges[-1], 'Hz')}</div></div>"
        )
    steps = ["up to 1.5", *(f"{a:g} to {b:g}" for a, b in pairwise(CHART.levels)), f"over {CHART.levels[-1]:g}"]
    keys = "".join(f"<span class='key cell l{i}'>{step}</span>" for i, step in enumerate(steps))
    return (
        f"<figure class='chart'><div class='legend'><span>times the noise:</span>{keys}"
        f"<span class='key framed'>most of the difference</span></div>{''.join(parts)}</figure>"
    )


def over_time(series: Sequence[Series], values: Sequence[Array], span: Pair) -> tuple[Array, Array]:
    """Return edges (m + 1,) s and each channel's RMS (channels, m) of values between them, NaN where there are none."""
    count = max(1, min(CHART.columns, round((span[1] - span[0]) / LOCALIZE.bin_s)))
    edges = np.linspace(*span, count + 1)
    out = []
    for s, z in zip(series, values, strict=True):
        at = np.clip(np.searchsorted(edges, s.time, side="right") - 1, 0, count - 1)
        numbers = np.bincount(at, minlength=count).astype(float)
        numbers[numbers == 0] = np.nan
        out.append(np.sqrt(np.bincount(at, z**2, count) / numbers))
    return edges, np.stack(out)


def over_frequency(series: Sequence[Series], values: Sequence[Array]) -> tuple[Array, Array]:
    """Return edges (m + 1,) Hz and the amplitude over that of white noise (channels, m), NaN above a sensor's reach."""
    found = [
        (*spectrum(s.time, z[:, None]), float(np.median(np.diff(s.time)))) for s, z in zip(series, values, strict=True)
    ]
    edges = np.linspace(0.0, max(f[-1] for f, _, _ in found), CHART.bins + 1)
    centres = 0.5 * (edges[1:] + edges[:-1])
    out = []
    for f, density, step in found:
        at = np.minimum(np.searchsorted(edges, f, side="right") - 1, CHART.bins - 1)
        numbers = np.bincount(at, minlength=CHART.bins).astype(float)
        numbers[numbers == 0] = np.nan
        mean = np.bincount(at, density[:, 0], CHART.bins) / numbers
        seen = np.isfinite(mean)
        mean = np.interp(centres, centres[seen], mean[seen], right=np.nan)
        out.append(np.sqrt(mean / (2 * step)))
    return edges, np.stack(out)


def _cells(edges: Array, levels: Array, frames: str) -> str:
    """Return the map's cells, neighbours of one step as one, the palest left out."""
    rows, columns = levels.shape
    steps = np.searchsorted(CHART.levels, np.nan_to_num(levels, nan=0.0), side="right")
    paths: dict[int, list[str]] = {}
    for i, row in enumerate(steps):
        begins = np.flatnonzero(np.diff(row, prepend=-1))
        for begin, end in zip(begins, [*begins[1:], columns], strict=True):
            if step := int(row[begin]):
                paths.setdefault(step, []).append(f"M{begin} {i}h{end - begin}v1h-{end - begin}z")
    drawn = "".join(f"<path class='cell l{step}' d='{''.join(d)}'/>" for step, d in sorted(paths.items()))
    rules = "".join(f"<path class='grid' d='M0 {i}H{columns}'/>" for i in range(1, rows))
    return (
        f"<svg viewBox='0 0 {columns} {rows}' preserveAspectRatio='none' role='img' aria-label='map of what differs' "
        f"style='height:{1.15 * rows:.2f}rem'>{drawn}{rules}{frames}</svg>"
    )


def _frames(series: Sequence[Series], found: Sequence[tuple[str, Sequence[Pair]]], edges: Array) -> str:
    """Return frames around a sensor's rows where most of its difference is."""
    scale = (len(edges) - 1) / (edges[-1] - edges[0])
    out = []
    for at, spans in found:
        rows = [i for i, s in enumerate(series) if s.at == at]
        for low, high in spans if rows else ():
            left, right = (float(np.clip((x - edges[0]) * scale, 0, len(edges) - 1)) for x in (low, high))
            out.append(
                f"<rect class='frame' x='{left:.2f}' y='{rows[0]}' width='{right - left:.2f}' height='{len(rows)}'/>"
            )
    return "".join(out)


def _axis(low: float, high: float, unit: str) -> str:
    return f"<div class='ends'><span>{low:.3g}</span><span>{high:.3g} {unit}</span></div>"


__all__ = ["Series", "misfit_map", "of_simulation", "of_traces", "over_frequency", "over_time"]
