"""Small pictures in SVG: lines over time and bars, without any package."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from imubench.arrays import Array

WIDTH, HEIGHT, ROW, LEFT, RIGHT = 360, 56, 18, 150, 90
COLOURS = ("#1f6fb4", "#c8641e", "#3a8f4d")
POINTS = 90  # across the picture: two for each, the least and the greatest


def traces(title: str, time: Array, values: Array) -> str:
    """Return a picture of columns (n, k) over time (n,)."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    spread = (high - low) or 1.0
    lines = []
    for k, column in enumerate(values.T):
        x, y = _thinned(time, column)
        across = WIDTH * (x - time[0]) / ((time[-1] - time[0]) or 1.0)
        down = HEIGHT - 2 - (HEIGHT - 4) * (y - low) / spread
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True) if np.isfinite(b))
        colour = COLOURS[k % len(COLOURS)]
        lines.append(f"<polyline fill='none' stroke='{colour}' stroke-width='0.8' points='{points}'/>")
    return _figure(title, "".join(lines), WIDTH, HEIGHT)


def bars(title: str, sizes: Mapping[str, float], shown: Sequence[str]) -> str:
    """Return a picture of sizes >= 0 by name, each with what is shown beside it."""
    most = max([*sizes.values(), 0.0]) or 1.0
    reach = WIDTH - LEFT - RIGHT
    rows = []
    for k, ((name, value), text) in enumerate(zip(sizes.items(), shown, strict=True)):
        y, length = k * ROW, max(1.0, reach * value / most)
        rows.append(
            f"<text x='{LEFT - 6}' y='{y + 13}' text-anchor='end'>{escape(name)}</text>"
            f"<rect x='{LEFT}' y='{y + 4}' width='{length:.1f}' height='11' fill='{COLOURS[0]}'/>"
            f"<text x='{LEFT + length + 5:.1f}' y='{y + 13}'>{escape(text)}</text>"
        )
    return _figure(title, "".join(rows), WIDTH, ROW * len(sizes))


def _figure(title: str, content: str, width: int, height: int) -> str:
    return (
        f"<svg viewBox='0 0 {width} {height}' width='{width}' height='{height}' role='img' font-size='11' "
        f"font-family='sans-serif' fill='currentColor' aria-label='{escape(title, quote=True)}'>{content}</svg>"
    )


def _thinned(time: Array, column: Array) -> tuple[Array, Array]:
    """Return at most 2 `POINTS` samples that look the same: the least and the greatest of each stretch."""
    if time.size <= 2 * POINTS:
        return time, column
    rows: set[int] = set()
    for stretch in np.array_split(np.arange(time.size), POINTS):
        part = column[stretch]
        if np.isfinite(part).any():
            rows |= {int(stretch[np.nanargmin(part)]), int(stretch[np.nanargmax(part)])}
    kept = np.array(sorted(rows), dtype=int)
    return time[kept], column[kept]
