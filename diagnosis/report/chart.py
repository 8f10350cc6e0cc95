"""Charts as SVG that stretch with the page: curves in a viewBox, words and numbers in HTML beside them.

The SVG has no size of its own and is stretched both ways (`preserveAspectRatio="none"`), lines keep their width
(`vector-effect`), and every word is HTML text, so it is as large on a phone as on a desktop. Colours are CSS classes:
the page's style sheet has them for light and for dark.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.report import CHART
from imubench.reproduce.report import escape


@dataclass(frozen=True)
class Line:
    """A curve of a panel, or dots."""

    time: Array  # (n,)
    values: Array  # (n,)
    kind: str  # a class of the style sheet: measured, before, after
    dots: bool = False


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    title: str  # what is drawn, with its unit
    lines: Sequence[Line]
    span: tuple[float, float]  # of the horizontal axis
    unit: str  # of the horizontal axis
    band: float = 0.0  # half the height of the grey band about 0; 0: none
    marked: Sequence[tuple[float, float]] = ()  # stretches of the horizontal axis that are shaded
    log: bool = False  # the vertical axis
    tall: bool = True


def chart(title: str, panels: Sequence[Panel], keys: Sequence[tuple[str, str]], note: str = "") -> str:
    """Return a figure: its title, its legend as (class, words), its panels one above the other, and a note."""
    legend = "".join(f"<span class='key {kind}'>{escape(words)}</span>" for kind, words in keys)
    below = f"<p class='soft small'>{escape(note)}</p>" if note else ""
    body = "".join(panel(p) for p in panels)
    return (
        f"<figure class='chart'><figcaption>{escape(title)}</figcaption>"
        f"<div class='legend'>{legend}</div>{body}{below}</figure>"
    )


def panel(p: Panel) -> str:
    """Return one pair of axes."""
    low, high = limits(p)
    scale = np.log10 if p.log else np.asarray

    def across(x: Array) -> Array:
        return np.asarray((np.asarray(x) - p.span[0]) / (p.span[1] - p.span[0]) * CHART.width)

    def up(y: Array) -> Array:
        bottom, top = float(scale(low)), float(scale(high))
        return np.asarray((1 - (scale(np.clip(y, low, None) if p.log else y) - bottom) / (top - bottom)) * CHART.height)

    parts = []
    for a, b in p.marked:
        left, right = np.clip(across(np.array([a, b])), 0, CHART.width)
        if right > left:
            parts.append(
                f"<rect class='held' x='{left:.0f}' y='0' width='{right - left:.0f}' height='{CHART.height}'/>"
            )
    if p.band:
        top, bottom = up(np.array([p.band, -p.band]))
        parts.append(
            f"<rect class='band' x='0' y='{top:.1f}' width='{CHART.width}' height='{max(bottom - top, 1):.1f}'/>"
        )
    vertical = log_ticks(low, high) if p.log else ticks(low, high, 4)
    for value in vertical:
        parts.append(f"<path class='grid' d='M0 {float(up(np.array(value))):.1f}H{CHART.width}'/>")
    for line in p.lines:
        inside = (line.time >= p.span[0]) & (line.time <= p.span[1]) & np.isfinite(line.values)
        x, y = across(line.time[inside]), up(line.values[inside])
        few = line.dots and inside.sum() <= CHART.width // 3  # pixels: more are a broad pale line
        drawn = dots(x, y) if few else "".join(path(x[run], y[run]) for run in unbroken(x))
        kind = f"{line.kind} dots" if few else line.kind
        parts.append(f"<path class='line {kind}' d='{drawn}'/>")
    y_labels = "".join(
        f"<span style='top:{float(up(np.array(v))) / CHART.height:.1%}'>{number(v, vertical)}</span>" for v in vertical
    )
    horizontal = ticks(*p.span, CHART.ticks)
    x_labels = "".join(
        f"<span style='left:{float(across(np.array(v))) / CHART.width:.1%}'>{number(v, horizontal)}"
        f"{' ' + escape(p.unit) if i == len(horizontal) - 1 else ''}</span>"
        for i, v in enumerate(horizontal)
    )
    tall = "" if p.tall else " low"
    return (
        f"<p class='axis'>{escape(p.title)}</p><div class='panel{tall}'><div class='ys'>{y_labels}</div>"
        f"<svg viewBox='0 0 {CHART.width} {CHART.height}' preserveAspectRatio='none' role='img' "
        f"aria-label='{escape(p.title)}'>{''.join(parts)}</svg><div class='xs'>{x_labels}</div></div>"
    )


def limits(p: Panel) -> tuple[float, float]:
    """Return the lowest and the highest value of a panel, with a little air."""
    shown = [
        line.values[(line.time >= p.span[0]) & (line.time <= p.span[1]) & np.isfinite(line.values)] for line in p.lines
    ]
    values = np.concatenate([*shown, [p.band, -p.band] if p.band else []])
    if p.log:
        values = values[values > 0]
        low, high = (float(values.min()), float(values.max())) if values.size else (0.1, 1.0)
        return max(low, high * 1e-5) / 1.3, high * 1.3
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    air = 0.06 * (high - low) or abs(high) or 1.0
    return low - air, high + air


def unbroken(x: Array) -> list[slice]:
    """Return the runs of rising places (n,) between gaps of more than `CHART.gap` usual steps."""
    if len(x) < 2:
        return [slice(0, len(x))]
    steps = np.diff(x)
    breaks = np.flatnonzero(steps > CHART.gap * float(np.median(steps))) + 1
    edges = [0, *(int(b) for b in breaks), len(x)]
    return [slice(a, b) for a, b in pairwise(edges)]


def path(x: Array, y: Array) -> str:
    """Return a curve through points (n,) as SVG path data; what one pixel's width holds is its lowest and highest."""
    if not len(x):
        return ""
    x, y = thinned(x, y)
    points = np.round(np.stack([x, y], axis=1), 1)
    first, steps = points[0], np.round(np.diff(points, axis=0), 1)
    # steps of rounded points are exact to rounding, so nothing adds up
    return f"M{first[0]:g} {first[1]:g}l" + " ".join(f"{dx:g} {dy:g}" for dx, dy in steps) if len(steps) else ""


def thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """Return points (n,), rising in x, as at most two in each unit of x: the lowest and the highest, in their order."""
    if len(x) <= 2 * CHART.width:
        return x, y
    column = np.clip(x.astype(int), 0, CHART.width - 1)
    edges = np.flatnonzero(np.diff(column, prepend=-1))
    kept = set()
    for begin, end in zip(edges, [*edges[1:], len(x)], strict=True):
        part = y[begin:end]
        kept |= {begin + int(np.argmin(part)), begin + int(np.argmax(part))}
    at = np.array(sorted(kept))
    return x[at], y[at]


def dots(x: Array, y: Array) -> str:
    """Return points (n,) as path data of dots: lines without a length, whose round ends show."""
    return "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(x, y, strict=True))


def ticks(low: float, high: float, count: int) -> list[float]:
    """Return about so many round numbers from `low` to `high`."""
    if not high > low:
        return [low]
    raw = (high - low) / count
    size = 10.0 ** np.floor(np.log10(raw))
    step = next(size * m for m in (1, 2, 5, 10) if size * m >= raw)
    first = int(np.ceil(low / step - 1e-9))
    return [i * step for i in range(first, int(np.floor(high / step + 1e-9)) + 1)]


def log_ticks(low: float, high: float) -> list[float]:
    """Return the powers of ten between two numbers above 0; their ends where there is none."""
    powers = [10.0**k for k in range(int(np.ceil(np.log10(low))), int(np.floor(np.log10(high))) + 1)]
    return powers[:: max(1, len(powers) // 4 + (len(powers) % 4 > 0))] or [low, high]


def number(value: float, beside: Sequence[float]) -> str:
    """Return a tick's number with the decimals that its neighbours need."""
    if len(beside) > 1 and beside[0] > 0 and beside[1] / beside[0] > 9.99:  # powers of ten
        return f"{value:g}"
    step = abs(beside[1] - beside[0]) if len(beside) > 1 else abs(value) or 1.0
    decimals = int(np.clip(-np.floor(np.log10(step) + 1e-9), 0, 9))
    text = f"{value:.{decimals}f}"
    return (text if float(text) else text.lstrip("-")).replace("-", "−")


__all__ = ["Line", "Panel", "chart", "panel", "path", "thinned", "ticks"]
