"""The figures of a diagnosis: a map of the misfit, and each finding before and after."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.evidence import Comparison, Evidence, Trace
from imubench.diagnosis.report.numbers import shown
from imubench.diagnosis.report.words import covers
from imubench.diagnosis.result import Finding, Pair, Where
from imubench.diagnosis.spectra import spectrum

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

INK, SOFT, LINE = "#1c2328", "#55606a", "#dde2e6"
BEFORE, AFTER, MARK, HELD = "#c8641e", "#1e7d4f", "#1f6fb4", "#9aa3ab"
COLUMNS = 120  # of a map
LOUDEST = 30.0  # times the noise: the map's darkest
EXCERPT = 3.0  # s
FONT = {"font.family": "DejaVu Sans", "font.size": 9, "text.color": INK, "axes.labelcolor": INK}


def misfit_map(evidence: Evidence, where: Sequence[Where]) -> "Drawing":
    """Return every channel's RMS residual over noise, over time and over frequency, before and after."""
    from matplotlib.figure import Figure as Canvas

    sides = [("as declared", [t.whitened for t in evidence.traces])]
    after = [t.whitened_after for t in evidence.traces]
    if any(z is not None for z in after):
        found = [t.whitened if z is None else z for t, z in zip(evidence.traces, after, strict=True)]
        sides.append(("with what was found in it", found))
    rows = sum(len(t.channels) for t in evidence.traces)
    figure = Canvas(figsize=(11, len(sides) * (0.75 + 0.19 * rows) + 0.55), layout="constrained")
    grid = figure.subplots(len(sides), 2, squeeze=False, width_ratios=[2.1, 1])
    top = max(float(over_time(evidence.traces, z)[1].max()) for _, z in sides[:1])
    drawn: Any = None
    for i, (name, z) in enumerate(sides):
        (edges, levels), (f_edges, f_levels) = over_time(evidence.traces, z), over_frequency(evidence.traces, z)
        for axes, x, y in ((grid[i][0], edges, levels), (grid[i][1], f_edges, f_levels)):
            drawn = _heat(axes, x, y, min(LOUDEST, max(top, 3.0)))
            _label_channels(axes, evidence.traces, names=axes is grid[i][0])
        grid[i][0].set_title(f"The model {name}", loc="left", fontsize=10, fontweight="bold", pad=14)
        if i == 0:
            parts = [(w.at, tuple(p for p in w.windows_s if not covers(p, evidence.span))) for w in where]
            _mark(grid[i][0], evidence.traces, parts)
            _mark(grid[i][1], evidence.traces, [(w.at, w.bands_hz) for w in where])
        _held_out(grid[i][0], evidence.heldout_s)
        grid[i][0].set_xlabel("time (s)" if i == len(sides) - 1 else "")
        grid[i][1].set_xlabel("frequency (Hz)" if i == len(sides) - 1 else "")
    bar = figure.colorbar(drawn, ax=grid.ravel().tolist(), shrink=0.8, aspect=30, pad=0.01, extend="max")
    bar.set_label("residual over noise (RMS)")
    ticks = [t for t in (1, 2, 3, 5, 10, 20, 30) if t <= min(LOUDEST, max(top, 3.0))]
    bar.set_ticks(ticks, labels=[f"{t:g}" for t in ticks])
    bar.ax.minorticks_off()
    return figure


def over_time(traces: Sequence[Trace], whitened: Sequence[Array]) -> tuple[Array, Array]:
    """Return edges (m + 1,) s and whitened residuals' RMS (channels, m) between them, NaN where there are none."""
    start, end = min(t.time[0] for t in traces), max(t.time[-1] for t in traces)
    count = max(1, min(COLUMNS, round((end - start) / 0.5)))
    edges = np.linspace(start, end, count + 1)
    out = []
    for trace, z in zip(traces, whitened, strict=True):
        at = np.clip(np.searchsorted(edges, trace.time, side="right") - 1, 0, count - 1)
        numbers = np.bincount(at, minlength=count).astype(float)
        numbers[numbers == 0] = np.nan
        out += [np.sqrt(np.bincount(at, column**2, count) / numbers) for column in z.T]
    return edges, np.stack(out)


def over_frequency(traces: Sequence[Trace], whitened: Sequence[Array]) -> tuple[Array, Array]:
    """Return edges (m + 1,) Hz and the amplitude over that of white noise (channels, m), NaN above a sensor's reach."""
    found = [(*spectrum(t.time, z), float(np.median(np.diff(t.time)))) for t, z in zip(traces, whitened, strict=True)]
    highest = max(f[-1] for f, _, _ in found)
    edges = np.linspace(0.0, highest, 61)
    out = []
    for f, density, step in found:
        at = np.minimum(np.searchsorted(edges, f, side="right") - 1, 59)
        numbers = np.bincount(at, minlength=60).astype(float)
        numbers[numbers == 0] = np.nan
        for column in density.T:
            mean = np.bincount(at, column, 60) / numbers
            seen = np.isfinite(mean)
            centres = 0.5 * (edges[1:] + edges[:-1])
            mean = np.interp(centres, centres[seen], mean[seen], right=np.nan)
            out.append(np.sqrt(mean / (2 * step)))
    return edges, np.stack(out)


def _heat(axes: Any, edges: Array, levels: Array, top: float) -> Any:
    from matplotlib.colors import LinearSegmentedColormap, LogNorm

    colours = LinearSegmentedColormap.from_list(
        "misfit", ["#f4f6f7", "#f6d9b8", "#e8853a", "#b3261e", "#4a0d12"], bad="#ffffff"
    )
    rows = np.arange(len(levels) + 1)
    mesh = axes.pcolormesh(
        edges, rows, np.clip(levels, 1.0, None), cmap=colours, norm=LogNorm(1.0, top), rasterized=True
    )
    axes.set_ylim(len(levels), 0)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return mesh


def _label_channels(axes: Any, traces: Sequence[Trace], names: bool) -> None:
    rows = [f"{t.at} {channel.replace('_', ' ')}" for t in traces for channel in t.channels]
    axes.set_yticks(np.arange(len(rows)) + 0.5, rows if names else [""] * len(rows), fontsize=7.5)
    for edge in np.cumsum([len(t.channels) for t in traces])[:-1]:
        axes.axhline(edge, color="white", lw=2.5)


def _mark(axes: Any, traces: Sequence[Trace], found: Sequence[tuple[str, tuple[Pair, ...]]]) -> None:
    """Frame the rows of a sensor where its excess was found."""
    from matplotlib.patches import Rectangle

    for at, spans in found:
        rows = [i for i, name in enumerate(t.at for t in traces for _ in t.channels) if name == at]
        for low, high in spans:
            box = (low, rows[0] + 0.06), high - low, len(rows) - 0.12
            axes.add_patch(Rectangle(*box, fill=False, ec=MARK, lw=1.6, clip_on=False))


def _held_out(axes: Any, spans: Sequence[Pair]) -> None:
    for i, (low, high) in enumerate(spans):
        axes.plot([low, high], [-0.35, -0.35], color=HELD, lw=3, solid_capstyle="butt", clip_on=False)
        if i == len(spans) - 1:
            style = {"fontsize": 7, "color": SOFT, "va": "center", "annotation_clip": False}
            axes.annotate("held out", (high, -0.35), (4, 0), textcoords="offset points", **style)


def before_after(compared: Comparison) -> "Drawing":
    """Return one channel on held-out data: signal, error and the error's spectrum, before and after."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(11, 3.9), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[1.9, 1], height_ratios=[1, 0.9])
    signal, error = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    factor, unit = printed(compared.unit)
    time, noise = compared.time, factor * compared.noise
    measured, before, after = (factor * y for y in (compared.measured, compared.before, compared.after))
    some, wrong = loudest(time, measured - before), (measured - before, measured - after)
    signal.plot(time[some], measured[some], ".", color=INK, ms=3.5, label="measured")
    signal.plot(time[some], before[some], color=BEFORE, lw=1.2, label="model without it")
    signal.plot(time[some], after[some], color=AFTER, lw=1.2, label="model with it")
    signal.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3, frameon=False, fontsize=8)
    signal.set_title(f"{compared.channel} on held-out data ({unit})", loc="left", fontsize=9)
    signal.tick_params(labelbottom=False)
    error.axhspan(-2 * noise, 2 * noise, color=LINE, lw=0)
    for values, colour in zip(wrong, (BEFORE, AFTER), strict=True):
        error.plot(time[some], values[some], color=colour, lw=1.1)
    error.set_title(f"what the model gets wrong ({unit}); grey: sensor noise, 95 %", loc="left", fontsize=9)
    error.set_xlabel("time (s)")
    power = figure.add_subplot(grid[:, 1])
    _spectra(power, time, [(wrong[0], BEFORE, "without it"), (wrong[1], AFTER, "with it")], noise)
    power.set_title(f"the error over frequency ({unit} per √Hz)", loc="left", fontsize=9)
    for axes in (signal, error, power):
        _plain(axes)
    return figure


def left_over(evidence: Evidence, finding: Finding) -> "Drawing | None":
    """Return the loudest channel of something unknown: its residual where it is loudest, and its spectrum."""
    from matplotlib.figure import Figure as Canvas

    if finding.where is None:
        return None
    at, shares = finding.where.at, finding.where.channels
    channel = max(shares, key=lambda c: shares[c])
    if not any(t.at == at and channel in t.channels for t in evidence.traces):
        return None  # a torque: no sensor reads it
    trace, column = evidence.trace(at, channel)
    factor, unit = printed(trace.unit)
    values = factor * (trace.before if trace.after is None else trace.after)[:, column]
    some, noise = loudest(trace.time, values), factor * trace.noise
    figure = Canvas(figsize=(11, 2.7), layout="constrained")
    error, power = figure.subplots(1, 2, width_ratios=[1.9, 1])
    error.axhspan(-2 * noise, 2 * noise, color=LINE, lw=0)
    error.plot(trace.time[some], values[some], color=BEFORE, lw=1.1)
    error.set_title(
        f"what the model gets wrong of {at}'s {channel} ({unit}); grey: sensor noise, 95 %", loc="left", fontsize=9
    )
    error.set_xlabel("time (s)")
    _spectra(power, trace.time, [(values, BEFORE, "error")], noise)
    for low, high in finding.where.bands_hz:
        power.axvspan(low, high, color=MARK, alpha=0.1, lw=0)
    power.set_title(f"over frequency ({unit} per √Hz); blue: most of it", loc="left", fontsize=9)
    for axes in (error, power):
        _plain(axes)
    return figure


def printed(unit: str) -> tuple[float, str]:
    """Return factor and name of a unit in a figure."""
    factor, name = shown(1.0, unit)
    return factor, name.replace("^2", "²")


def loudest(time: Array, values: Array) -> slice:
    """Return the few seconds of times (n,) in which values (n,) are largest."""
    width = max(2, round(EXCERPT / float(np.median(np.diff(time)))))
    if width >= len(time):
        return slice(0, len(time))
    power = np.concatenate([[0.0], np.cumsum(values**2)])
    inside = (time[width - 1 :] - time[: len(time) - width + 1]) < 1.2 * EXCERPT  # not across a gap
    held = np.where(inside, power[width:] - power[: len(power) - width], -1.0)
    start = int(np.argmax(held))
    return slice(start, start + width)


def _spectra(axes: Any, time: Array, lines: Sequence[tuple[Array, str, str]], noise: float) -> None:
    step = float(np.median(np.diff(time)))
    for values, colour, name in lines:
        f, density = spectrum(time, values[:, None])
        axes.semilogy(f[1:], np.sqrt(density[1:, 0]), color=colour, lw=1.2, label=name)
    axes.axhline(noise * np.sqrt(2 * step), color=SOFT, lw=1, ls=(0, (4, 3)), label="sensor noise")
    axes.set_xlim(0, f[-1])
    axes.set_xlabel("frequency (Hz)")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("")
    axes.legend(frameon=False, fontsize=8)


def _plain(axes: Any) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(SOFT)
    axes.grid(axis="y", color="#e6e9ec", lw=0.6)
    axes.set_axisbelow(True)
    axes.margins(x=0.01)
