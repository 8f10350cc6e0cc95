"""The plots of the study of soft tissue."""

from typing import TYPE_CHECKING, Any

import numpy as np

from imubench.arrays import Array
from imubench.estimators.frick_rahmatalla import NAME as DESCENT
from imubench.reproduce.arve.soft_results import BANDS, FINE, MID, NOISIER, Soft
from imubench.reproduce.arve.soft_runs import DAMPING, METHODS
from imubench.reproduce.arve.style import QUIET, TRUTH, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

LABELS = {
    "arve": "ArVE",
    "arve-d": "ArVE_d",
    "mrvs": "MrVS",
    DESCENT: "gradient descent",
    "sliding": "sliding",
    "sliding-stream": "sliding-stream",
}
COLOURS = {"arve": "#c8641e", "arve-d": "#1f6fb4", "mrvs": "#7a3fa0", DESCENT: "#d99a1c", "sliding": "#2e8b57"}
SMALLEST, LARGEST = 0.1, 1000.0  # mm, ends of the colour scale
ROWS = {"sliding": "felt", "paper": "unfelt"}


def maps(s: Soft) -> "Drawing":
    """Draw a panel a method, felt above unfelt."""
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(14, 5.2), layout="constrained")
    panels = figure.subplots(2, len(METHODS), sharex=True, sharey=True)
    x, y = s.extent.frequencies, ["0", *(f"{1e3 * a:g}" for a in s.extent.amplitudes)]
    for line, kind in zip(panels, ROWS, strict=True):
        for axes, method in zip(line, METHODS, strict=True):
            still = np.full((1, len(x)), s.still[1.0][method].mean())
            error = 1e3 * np.concatenate([still, s.maps[kind, 1.0][method].mean(axis=-1)])
            shown = axes.imshow(error, norm=LogNorm(SMALLEST, LARGEST), cmap="viridis", origin="lower", aspect="auto")
            for (i, j), value in np.ndenumerate(error):
                text = f"{value:.0f}" if value >= 10 else f"{value:.1f}"
                axes.text(j, i, text, ha="center", va="center", fontsize=7.5, color="black" if value > 30 else "white")
            axes.set_title(f"{LABELS[method]}, {ROWS[kind]}", fontsize=10)
            axes.set_xticks(range(len(x)), [f"{f:g}" for f in x])
            axes.set_yticks(range(len(y)), y)
        line[0].set_ylabel("amplitude, mm")
    for axes in panels[-1]:
        axes.set_xlabel("frequency of the slide, Hz")
    bar = figure.colorbar(shown, ax=panels, label="mean |Δr|, mm", ticks=[0.1, 1, 10, 100, 1000], extend="both")
    bar.ax.set_yticklabels(["0.1", "1", "10", "100", "1000"])
    return figure


def explanations(s: Soft) -> "Drawing":
    """Draw MrVS over the gyroscope's noise, and all methods with it and without."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    kinds = (
        ("none", "r constant", QUIET),
        ("paper", "20 mm at 1 Hz, unfelt", "#1f6fb4"),
        ("sliding", "felt", "#c0392b"),
    )
    for kind, label, colour in kinds:
        left.plot(NOISIER, 1e3 * s.noisier[kind], "o-", ms=4, color=colour, label=label)
    left.axhline(65, color=TRUTH, ls=":", lw=1, label="65 mm, real hips")
    left.set_xscale("symlog", linthresh=1)
    left.set(yscale="log", xlabel="noise of the gyroscope, times the sensor's", ylabel="MrVS, mean |Δr|, mm")
    left.set_xlim(-0.15, 130)
    left.set_xticks(NOISIER, [f"{v:g}" for v in NOISIER])
    _over_frequency(right, s.extent.frequencies, {g: _rows(s, g) for g in (0.0, 1.0)})
    right.set_xlabel("frequency of a felt slide of 20 mm, Hz")
    for axes in (left, right):
        axes.legend(fontsize=8, frameon=False)
        plain(axes)
    return figure


def _rows(s: Soft, gyro: float) -> dict[str, Array]:
    k = s.extent.amplitudes.index(MID)
    return {m: s.maps["sliding", gyro][m][k, :, 0] for m in METHODS}


def _over_frequency(axes: Any, frequencies: tuple[float, ...], found: dict[float, dict[str, Array]]) -> None:
    """Draw errors of all methods with the gyroscope's noise as lines, without it as crosses."""
    for method in METHODS:
        axes.plot(frequencies, 1e3 * found[1.0][method], "-", color=COLOURS[method], label=LABELS[method])
        axes.plot(frequencies, 1e3 * found[0.0][method], "x", color=COLOURS[method], ms=6)
    axes.set(xscale="log", yscale="log", ylabel="mean |Δr|, mm")
    axes.set_xticks(frequencies, [f"{v:g}" for v in frequencies])
    axes.minorticks_off()


def sprung(s: Soft) -> "Drawing":
    """Draw errors over the springs' frequency."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(10, 4.6), layout="constrained")
    axes = figure.subplots()
    z, springs = s.extent.dampings.index(DAMPING), s.extent.springs
    _over_frequency(axes, springs, {g: {m: s.springs[g][m][z] for m in METHODS} for g in (0.0, 1.0)})
    axes.plot(springs, 1e3 * s.springs[1.0]["best constant"][z], "--", color=TRUTH, lw=1, label="best constant")
    peak = 1e3 * s.springs[1.0]["peak"][z]
    axes.set_xticks(springs, [f"{f:g}\n({p:.0f} mm)" for f, p in zip(springs, peak, strict=True)])
    axes.set_xlabel("frequency of the springs, Hz (largest displacement)")
    axes.legend(fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    plain(axes)
    return figure


def bounds(s: Soft) -> "Drawing":
    """Draw the bounds over the slide's frequency, and over the band of a free slide."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(FINE, 1e3 * s.bounds["sought"], color=TRUTH, lw=1.2, label="bound, frequency unknown")
    left.axhline(1e3 * float(s.bounds["only"]), color=QUIET, ls="--", lw=1, label="bound, r constant")
    k = s.extent.amplitudes.index(MID)
    reached = 1e3 * s.maps["sliding", 1.0]["sliding"][k]
    for i, column in enumerate(reached.T):
        label = "sliding, single runs" if i == 0 else None
        left.plot(s.extent.frequencies, column, "o", color=COLOURS["sliding"], ms=5, label=label)
    left.set(xlim=(0, 3.1), ylim=(0, None), xlabel="frequency of the slide, Hz", ylabel="of r(t), mm")
    for prior, colour in ((0.03, "#c0392b"), (0.003, "#1f6fb4")):
        label = f"each wave within {1e3 * prior:g} mm"
        right.plot(BANDS, 1e3 * s.bounds[f"free {prior:g}"], "o-", ms=4, color=colour, label=label)
    right.set(yscale="log", xlabel="highest frequency of a slide of any shape, Hz", ylabel="bound of r(t), mm")
    for axes in (left, right):
        axes.legend(fontsize=8, frameon=False)
        plain(axes)
    return figure
