"""The robustness maps as figures, each with its 3-deg contour."""

from typing import TYPE_CHECKING, Any

import numpy as np

from imubench.arrays import Array
from imubench.reproduce.olsson2020.robustness import LIMIT, SHOWN, Map
from imubench.reproduce.olsson2020.style import QUIET, SEGMENT1, SEGMENT2, plain
from imubench.reproduce.paper import Figure
from imubench.sim.sprung import MOST_TURN
from imubench.unplayed import cross, ground_of_legend, hatch

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

SMALLEST, LARGEST = 0.03, 100.0  # deg, ends of the colour scale
COLOURS = "YlGnBu"
NAMES = {"sequence1": "sequence 1 (all motions)", "sequence3": "sequence 3 (20 s of motion 6)"}


def exhibits(maps: dict[str, Map]) -> tuple[Figure, ...]:
    """Return the four maps."""
    return (
        bias_figure(maps["bias"]),
        soft_figure(maps["soft"]),
        banded_figure(maps["banded"], maps["soft"]),
        offset_figure(maps["offset"]),
    )


def first_above(levels: Array, errors: Array) -> float:
    """Return the level at which errors (k,) in rad first exceed LIMIT, interpolated in the logarithms; inf if never.

    A level that cannot be played (NaN) exceeds it, and nothing is interpolated up to there.
    """
    above = np.flatnonzero(~(errors <= LIMIT))
    if not above.size:
        return float("inf")
    k = int(above[0])
    if k == 0 or np.isnan(errors[k]):
        return float(levels[k])
    y = np.log(errors[k - 1 : k + 1] / LIMIT)
    part = -y[0] / (y[1] - y[0])
    return float(np.exp(np.log(levels[k - 1]) * (1 - part) + np.log(levels[k]) * part))


def bias_figure(m: Map) -> Figure:
    """Return the error over both biases."""
    gyro = [first_above(m.x, error[:, 0]) for error in m.error]
    accel = [first_above(m.y, error[0]) for error in m.error]
    finding = (
        f"Alone, a gyroscope bias stops it from {_or_more(min(gyro), m.x)} deg/s on, an accelerometer bias from "
        f"{_or_more(min(accel), m.y)} m/s² on"
    )
    text = (
        "RMSAE at the end of the sequence, N_max = 500, with biases of these sizes added to both sensors in random "
        "directions. Thick: 3 deg; thin: 0.1, 0.3, 1, 10 and 30 deg. Red dot: the biases of the paper's section "
        "7.5. This is the estimate from all the data; Algorithm 4 may accept earlier ones, which are worse."
    )
    return Figure("map-bias", "Robustness: biases", finding, text, lambda: draw_bias(m))


def soft_figure(m: Map) -> Figure:
    """Return the error over frequency and damping of soft mounts."""
    limits = [max(_softest(m, error[:, k]) for k in range(m.y.size)) for error in m.error]
    words = [f"about {x:.1f} Hz" if x else f"less than {m.x.min():g} Hz" for x in limits]
    finding = f"A mount must be stiffer than {words[0]}, or {words[1]} with 20 s of useful motion, whatever its damping"
    text = (
        "Both IMUs stand on springs along and about all axes, their centre of mass 7 mm above the surface; motions of "
        "10 s, motion 6 of 20 s. RMSAE against the nominal axis at the end of the sequence, N_max = 500. Thick: 3 deg; "
        "thin: 0.1, 0.3, 1, 10 and 30 deg."
    )
    if not m.played.all():
        text += (
            f" Of {m.played.size} points {m.played.sum()} could be played (dots). At the crosses a sensor turns by "
            f"over {MOST_TURN:g} rad, beyond the range of its springs: there is no error to show, and the mount "
            "counts as too soft."
        )
    return Figure("map-soft", "Robustness: soft mounts", finding, text, lambda: draw_soft(m))


def banded_figure(m: Map, plain: Map) -> Figure:
    """Return the error over frequency and damping of soft mounts below a band, beside that of the method as it is."""
    rows, columns = np.isin(plain.x, m.x), np.isin(plain.y, m.y)
    before = plain.error[:, rows][:, :, columns]
    told = np.isfinite(before) & np.isfinite(m.error)
    parts = [float(np.exp(np.log(a[t] / b[t]).mean())) for a, b, t in zip(m.error, before, told, strict=True)]
    finding = (
        f"Below a band that the data choose the error of soft mounts is {parts[0]:.2f} times as large, and "
        f"{parts[1]:.2f} times with 20 s of useful motion"
    )
    text = (
        "The same rigs, with olsson2020-banded on all samples: both IMUs' rates below a frequency at which they still "
        "obey the hinge. What a mount hangs over by under its own weight stays in the error: it turns the axis itself."
    )
    if not m.played.all():
        text += " Crosses: points that cannot be played, as above; they are in neither figure."
    return Figure("map-banded", "Robustness: soft mounts, below a band", finding, text, lambda: draw_soft(m))


def offset_figure(m: Map) -> Figure:
    """Return the error over the time offset."""
    late, early = m.x >= 0, m.x <= 0
    stops = [
        min(_linear_stop(m.x[late], error[late, 0]), _linear_stop(-m.x[early][::-1], error[early, 0][::-1]))
        for error in m.error
    ]
    words = [f"up to {x:.0f} ms" if np.isfinite(x) else f"within the {m.x.max():g} ms tried" for x in stops]
    finding = f"A time offset is harmless {words[0]} with all motions, and {words[1]} with 20 s of one"
    text = (
        "RMSAE at the end of the sequence, N_max = 500, over the offset of imu2's stamps; one sample is 20 ms. Dashed: "
        "3 deg. Motions of 10 s, motion 6 of 20 s."
    )
    return Figure("map-offset", "Robustness: time offset", finding, text, lambda: draw_offset(m))


def _softest(m: Map, errors: Array) -> float:
    """Return the highest frequency at which the error still exceeds LIMIT."""
    stiffness = 1.0 / m.x[::-1]
    stop = first_above(stiffness, errors[::-1])
    return 1.0 / stop


def _linear_stop(levels: Array, errors: Array) -> float:
    """Return as `first_above`, but interpolated linearly: levels may be zero."""
    above = np.flatnonzero(errors > LIMIT)
    if not above.size:
        return float("inf")
    k = int(above[0])
    if k == 0:
        return float(levels[0])
    part = (LIMIT - errors[k - 1]) / (errors[k] - errors[k - 1])
    return float(levels[k - 1] + part * (levels[k] - levels[k - 1]))


def _or_more(stop: float, levels: Array) -> str:
    return f"{stop:.2g}" if np.isfinite(stop) else f"more than {levels.max():g}"


def draw_bias(m: Map) -> "Drawing":
    """Draw the bias map of both sequences."""
    figure, panels = _panels(m, "added gyroscope bias, deg/s", "added accelerometer bias, m/s²")
    for axes in panels:
        axes.plot(1.0, 1.0, "o", color="#c0392b", ms=7, mec="white")
        axes.annotate("section 7.5", (1.0, 1.0), xytext=(7, 4), textcoords="offset points", color="#c0392b", fontsize=8)
    return figure


def draw_soft(m: Map) -> "Drawing":
    """Draw the soft-mount map of both sequences; hatched with crosses is what cannot be played."""
    figure, panels = _panels(m, "natural frequency of the mounts, Hz", "damping ratio")
    if m.played.all():
        return figure
    x, y = (grid.ravel() for grid in np.meshgrid(m.x, m.y, indexing="ij"))
    played = m.played.ravel()
    over: dict[str, Any] = {"zorder": 4, "clip_on": False}
    # The cells at an unplayed corner, which no colour fills.
    boxes = [(*_beside(m.x, i), *_beside(m.y, k)) for i, k in np.argwhere(~m.played)]
    for axes, error in zip(panels, np.rad2deg(m.error), strict=True):
        hatch(axes, boxes)
        axes.set(xlim=m.x[[0, -1]], ylim=m.y[[0, -1]])
        shades = {"norm": _norm(), "cmap": COLOURS, "edgecolors": "black", "s": 36}
        axes.scatter(x[played], y[played], c=error.ravel()[played], **shades, **over)
        crosses = cross(axes, x[~played], y[~played])
    share = f"{(~played).sum()} of {played.size} points"
    names = [f"cannot be played ({share}): the sensor leaves its springs' range; hatched: open up to there"]
    handles: list[Any] = [(ground_of_legend(), crosses)]  # one over the other
    figure.legend(handles, names, loc="outside lower left", frameon=False)
    return figure


def _beside(levels: Array, at: int) -> tuple[float, float]:
    """Return the levels before and after the one numbered `at`, or itself at an end."""
    return float(levels[max(at - 1, 0)]), float(levels[min(at + 1, levels.size - 1)])


def _panels(m: Map, x: str, y: str) -> "tuple[Drawing, Any]":
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 4.6), layout="constrained")
    panels = figure.subplots(1, len(SHOWN), sharey=True)
    levels, limit = np.geomspace(SMALLEST, LARGEST, 33), float(np.rad2deg(LIMIT))
    for axes, name, error in zip(panels, SHOWN, np.rad2deg(m.error), strict=True):
        axes.contourf(m.x, m.y, error.T, levels=levels, norm=_norm(), cmap=COLOURS, extend="both")
        within = [x for x in (0.1, 0.3, 1.0, limit, 10.0, 30.0) if np.nanmin(error) < x < np.nanmax(error)]
        for level in within:  # matplotlib warns of lines that are nowhere
            colour, width = ("black", 2.2) if level == limit else ("#5b6b75", 0.5)
            line = axes.contour(m.x, m.y, error.T, levels=[level], colors=colour, linewidths=width)
            if level == limit:
                axes.clabel(line, fmt="3 deg", fontsize=9)
        axes.set(xscale="log", yscale="log", xlabel=x)
        axes.set_xticks(m.x, [f"{v:g}" for v in m.x])
        axes.set_yticks(m.y, [f"{v:g}" for v in m.y])
        axes.minorticks_off()
        axes.set_title(NAMES[name], fontsize=10)
    panels[0].set_ylabel(y)
    shades = ScalarMappable(_norm(), COLOURS)
    bar = figure.colorbar(shades, ax=panels, label="RMSAE, deg", ticks=[0.1, 0.3, 1, 3, 10, 30, 100], extend="both")
    bar.ax.set_yticklabels(["0.1", "0.3", "1", "3", "10", "30", "100"])
    return figure, panels


def _norm() -> Any:
    from matplotlib.colors import LogNorm

    return LogNorm(SMALLEST, LARGEST)


def draw_offset(m: Map) -> "Drawing":
    """Draw the error over the offset, one curve a sequence."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(8, 4.2), layout="constrained")
    axes = figure.subplots()
    for name, colour, error in zip(SHOWN, (SEGMENT1, SEGMENT2), np.rad2deg(m.error), strict=True):
        axes.plot(m.x, error[:, 0], ".-", color=colour, label=NAMES[name])
    axes.axhline(np.rad2deg(LIMIT), color="black", ls="--", lw=1)
    axes.annotate("3 deg", (m.x[0], np.rad2deg(LIMIT)), xytext=(2, 3), textcoords="offset points", fontsize=8)
    for sample in (-20.0, 20.0):
        axes.axvline(sample, color=QUIET, lw=0.6, ls=":")
    axes.set(xlabel="offset of imu2's stamps, ms (dotted: one sample)", ylabel="RMSAE, deg", ylim=(0, None))
    axes.legend(frameon=False, loc="upper center")
    plain(axes)
    return figure
