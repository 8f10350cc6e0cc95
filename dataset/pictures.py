"""Distributions as SVG: small, the same to the byte every time, and without a plotting package."""

from collections.abc import Mapping
from html import escape

import numpy as np

from imubench.arrays import Array

WIDTH, HEIGHT, BASE = 300, 110, 84  # px; BASE: where bars stand
BINS = 30


def histogram(values: Array, title: str, unit: str, log: bool = False) -> str:
    """Return a figure of how values (n,) spread, with their median and the range of nine in ten; '' of none."""
    values = values[np.isfinite(values)]
    values = values[values > 0] if log else values
    if not values.size:
        return ""
    low, high = float(values.min()), float(values.max())
    if low == high:
        return figure(title, f"<text x='8' y='60'>always {number(low)} {escape(unit)}</text>", f"{values.size} values")
    scale = np.log if log else np.asarray
    counts = np.histogram(scale(values), bins=BINS, range=(float(scale(low)), float(scale(high))))[0]
    step = WIDTH / BINS
    bars = "".join(
        f"<rect x='{i * step:.1f}' y='{BASE - h:.1f}' width='{step - 1:.1f}' height='{h:.1f}'/>"
        for i, h in enumerate(counts / counts.max() * (BASE - 12))
        if h > 0
    )
    ends = (
        f"<text x='0' y='{HEIGHT - 8}'>{number(low)}</text>"
        f"<text x='{WIDTH}' y='{HEIGHT - 8}' text-anchor='end'>{number(high)} {escape(unit)}</text>"
        f"<line x1='0' x2='{WIDTH}' y1='{BASE}' y2='{BASE}'/>"
    )
    five, median, ninety_five = (number(float(q)) for q in np.quantile(values, [0.05, 0.5, 0.95]))
    note = f"median {median}, nine in ten from {five} to {ninety_five} {unit}" + (", scale logarithmic" if log else "")
    return figure(title, bars + ends, note)


def shares(counts: Mapping[str, int], title: str, total: int) -> str:
    """Return a figure of how often each of some names comes among `total`; '' of none."""
    if not counts:
        return ""
    row, label = 20, 150
    height = row * len(counts) + 6
    drawn = "".join(
        f"<text x='0' y='{i * row + 15}'>{escape(name)}</text>"
        f"<rect x='{label}' y='{i * row + 4}' width='{max(1.0, 90 * n / total):.1f}' height='13'/>"
        f"<text x='{label + 96}' y='{i * row + 15}'>{100 * n / total:.1f} %</text>"
        for i, (name, n) in enumerate(sorted(counts.items(), key=lambda pair: (-pair[1], pair[0])))
    )
    return figure(title, drawn, f"of {total}", height)


def figure(title: str, content: str, note: str, height: int = HEIGHT) -> str:
    """Return a figure with its title above and a note below."""
    return (
        f"<figure><figcaption>{escape(title)}</figcaption>"
        f"<svg viewBox='0 0 {WIDTH} {height}' width='{WIDTH}' height='{height}' role='img' "
        f"aria-label='{escape(title, quote=True)}'>{content}</svg><p>{escape(note)}</p></figure>"
    )


def number(value: float) -> str:
    """Return a number for people: three digits."""
    return f"{value:.3g}"
