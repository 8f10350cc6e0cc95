"""Maps and curves of a sweep, as SVG that stands in a page and takes its ink from there."""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from imubench.arrays import Array
from imubench.sweeps.axis import Axis
from imubench.sweeps.cells import Map
from imubench.sweeps.spec import Sweep
from imubench.unplayed import cross, hatch

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

INK = "#102030"  # becomes the page's own ink, by day and by night
COLOURS = "RdBu_r"  # blue below the limit, red above; told apart by the colour-blind
SILENT = "#4a4a4a"  # a cell without an answer
LINES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # Okabe and Ito, for the colour-blind
NARROWEST, WIDEST = 4.0, 32.0  # times the limit, ends of the colour scale either way
SIZE, WIDE = (4.7, 3.7), (7.5, 4.2)  # inches of 96 px on a page
MOST_TICKS = 8


def figures(sweep: Sweep, found: Sequence[Map]) -> "list[Drawing]":
    """Return one map an estimator, or one figure of all curves where there is one axis."""
    with _style():
        if len(sweep.axes) == 1:
            return [_curves(sweep, found)]
        span = _span(sweep, found)
        return [_map(sweep, m, span) for m in found]


def svg(figure: "Drawing", name: str) -> str:
    """Return a figure as an element of a page; the same figure and name give the same text."""
    from matplotlib import rc_context

    buffer = io.StringIO()
    with rc_context({"svg.hashsalt": name, "svg.fonttype": "none"}):
        figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :].replace(INK, "currentColor").strip()


@contextmanager
def _style() -> Iterator[None]:
    from matplotlib import rc_context

    inked = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
    with rc_context({"font.size": 10, "hatch.linewidth": 0.8, **dict.fromkeys(inked, INK)}):
        yield


def _span(sweep: Sweep, found: Sequence[Map]) -> float:
    """Return the end of the colour scale, the natural logarithm of times the limit, the same for all maps."""
    values = np.concatenate([m.value.ravel() for m in found])
    values = values[np.isfinite(values) & (values > 0)]
    most = float(np.abs(np.log(values / sweep.limit)).max(initial=0.0))
    return float(np.clip(most, np.log(NARROWEST), np.log(WIDEST)))


def _map(sweep: Sweep, m: Map, span: float) -> "Drawing":
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    x, y = (_across(axis) for axis in sweep.axes)
    left, low = _edges(x), _edges(y)
    with np.errstate(divide="ignore"):
        shade = np.log(m.value / sweep.limit)  # NaN: nothing played; inf: no answer
    silent = np.isposinf(shade)
    coloured = np.ma.masked_invalid(np.where(silent, np.nan, np.maximum(shade, -2 * span)))
    drawn = axes.pcolormesh(
        left, low, coloured.T, cmap=COLOURS, vmin=-span, vmax=span, edgecolors="face", linewidth=0.3
    )
    for i, j in np.argwhere(silent):
        _fill(axes, (left[i], left[i + 1], low[j], low[j + 1]))
    gone = m.played == 0
    hatch(axes, [(left[i], left[i + 1], low[j], low[j + 1]) for i, j in np.argwhere(gone)], zorder=1)
    part = np.argwhere(m.played < 1)
    cross(axes, x[part[:, 0]], y[part[:, 1]], 5, on_colours=True)
    some = np.argwhere((m.failed > 0) & ~silent & ~gone)
    axes.scatter(x[some[:, 0]], y[some[:, 1]], s=60 * m.failed[tuple(some.T)], color=SILENT, zorder=3)
    if not any(axis.is_text for axis in sweep.axes):
        low_end = np.where(m.low > 0, m.low, np.nan)  # 0: too few recordings for an end
        for of, look in ((low_end, "dashed"), (m.high, "dashed"), (m.value, "solid")):
            _contour(axes, x, y, of, sweep.limit, look)
    for axis, set_ticks in zip(sweep.axes, (axes.set_xticks, axes.set_yticks), strict=True):
        set_ticks(*_ticks(axis))
    axes.set(xlabel=sweep.axes[0].title, ylabel=sweep.axes[1].title)
    axes.set(xlim=left[[0, -1]], ylim=low[[0, -1]])
    axes.spines[:].set_visible(False)
    _bar(figure, axes, drawn, sweep, span)
    return figure


def _fill(axes: Any, box: tuple[float, float, float, float]) -> None:
    from matplotlib.patches import Rectangle

    left, right, low, high = box
    axes.add_patch(Rectangle((left, low), right - left, high - low, color=SILENT, lw=0))


def _contour(axes: Any, x: Array, y: Array, of: Array, limit: float, look: str) -> None:
    """Draw where a value passes the limit; a cell without an answer lies above it, one without a recording nowhere."""
    with np.errstate(divide="ignore"):
        level = np.clip(np.log(of / limit), -7.0, 7.0)  # a thousandth, a thousand times: how steep no answer is drawn
    seen = level[np.isfinite(level)]
    if seen.size and seen.min() < 0 < seen.max():  # matplotlib warns of lines that are nowhere
        width = 2.2 if look == "solid" else 0.9
        axes.contour(
            x, y, np.ma.masked_invalid(level).T, levels=[0.0], colors="black", linewidths=width, linestyles=look
        )


def _bar(figure: Any, axes: Any, drawn: Any, sweep: Sweep, span: float) -> None:
    factors = [f for f in (1 / 16, 1 / 4, 1.0, 4.0, 16.0) if abs(np.log(f)) <= span + 1e-9]
    bar = figure.colorbar(drawn, ax=axes, extend="both", ticks=np.log(factors), label=f"error, {sweep.unit}")
    bar.ax.set_yticklabels([f"{f * sweep.limit:.2g}" for f in factors])
    bar.outline.set_visible(False)
    bar.ax.axhline(0.0, color="black", lw=2.2)


def _across(axis: Axis) -> Array:
    """Return where the values (n,) stand: their logarithms on a logarithmic axis."""
    return np.log(axis.places) if axis.scale == "log" else axis.places


def _edges(at: Array) -> Array:
    """Return the edges (n + 1,) of cells around places (n,): midway between them."""
    middle = (at[1:] + at[:-1]) / 2
    return np.concatenate([[2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]])


def _ticks(axis: Axis) -> tuple[list[float], list[str]]:
    """Return where an axis is labelled, and how."""
    places, across = axis.places, _across(axis)
    round_ones = axis.is_text or all(float(f"{v:.2g}") == v for v in places)
    if places.size <= MOST_TICKS and (round_ones or axis.scale == "linear"):
        return across.tolist(), [v if isinstance(v, str) else f"{v:.3g}" for v in axis.values]
    if axis.scale == "log":
        decades = range(int(np.floor(np.log10(places[0]))), int(np.ceil(np.log10(places[-1]))) + 1)
        for steps in ((1, 2, 3, 4, 5, 7), (1, 2, 5), (1, 3), (1,)):
            ticks = [s * 10.0**d for d in decades for s in steps if places[0] <= s * 10.0**d * (1 + 1e-9)]
            ticks = [t for t in ticks if t <= places[-1] * (1 + 1e-9)]
            if len(ticks) <= MOST_TICKS:
                break
        return np.log(ticks).tolist(), [f"{t:g}" for t in ticks]
    from matplotlib.ticker import MaxNLocator

    found = [t for t in MaxNLocator(MOST_TICKS - 1).tick_values(places[0], places[-1]) if places[0] <= t <= places[-1]]
    return found, [f"{t:g}" for t in found]


def _curves(sweep: Sweep, found: Sequence[Map]) -> "Drawing":
    """Draw the errors over one axis, a curve with its interval an estimator."""
    from matplotlib.figure import Figure as Canvas

    figure, axis = Canvas(figsize=WIDE, layout="constrained"), sweep.axes[0]
    axes, x = figure.subplots(), _across(axis)
    shown = np.concatenate([np.append(m.value[np.isfinite(m.value)], sweep.limit) for m in found])
    shown = shown[shown > 0]
    low, high = shown.min() / 2, shown.max() * 2
    for n, m in enumerate(found):
        colour, value = LINES[n % len(LINES)], m.value[:, 0]
        line = np.where(np.isfinite(value), np.clip(value, low, high), np.nan)
        axes.plot(x, line, "o" if axis.is_text else "o-", ms=4, color=colour, label=m.estimator)
        ends = [np.clip(of[:, 0], low, high) for of in (m.low, m.high)]
        told = (m.played[:, 0] > 0) & ~((m.low[:, 0] == 0) & np.isinf(m.high[:, 0]))  # else open at both ends
        if axis.is_text:
            axes.vlines(x[told], *(end[told] for end in ends), color=colour, lw=2, alpha=0.5)
        else:
            axes.fill_between(x, ends[0], ends[1], where=told.tolist(), color=colour, alpha=0.18, lw=0)
        silent = np.isposinf(value)
        axes.plot(x[silent], np.full(silent.sum(), high), "^", color=colour, ms=8, clip_on=False)
    part = found[0].played[:, 0] < 1
    cross(axes, x[part], np.full(part.sum(), low))
    axes.axhline(sweep.limit, color=INK, lw=1.2, ls="--")
    axes.set(yscale="log", ylim=(low, high), xlabel=axis.title, ylabel=f"error, {sweep.unit}")
    axes.set_xticks(*_ticks(axis))
    ticks = [t for d in range(-6, 7) for t in (10.0**d, 3 * 10.0**d) if low <= t <= high]
    axes.set_yticks(ticks, [f"{t:g}" for t in ticks])
    axes.minorticks_off()
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    return figure
