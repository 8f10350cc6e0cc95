"""Figure 5: the error over the relative weight of the residuals."""

from typing import TYPE_CHECKING

import numpy as np

from imubench.reproduce.olsson2020.measures_weights import worst_rmsae_between
from imubench.reproduce.olsson2020.results import Results, rmsae_over
from imubench.reproduce.olsson2020.settings import MOTIONS
from imubench.reproduce.olsson2020.style import MOTION_COLOURS, QUIET, plain
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing


def exhibit(r: Results) -> Figure:
    """Return figure 5."""
    worst = worst_rmsae_between(r, MOTIONS, 10.0, 1e5).value
    finding = f"For any weight from 10 to 100,000 the error is at most {worst:.2g} deg, for every motion"
    text = (
        f"RMSAE (eq. 71) of both axes over {r.settings.starts} starts from a grid, for each of "
        f"{r.settings.weights} weights "
        "w0 = w_gyro / w_accel; all samples of one motion at a time. Left the full scale, right the small "
        "errors, each axis "
        "scaled to its own curves. 90 deg means that half of the starts end in the wrong sign pairing."
        + (" Dots: the authors' own solver (the package qmt) on the same samples." if r.authors else "")
    )
    return Figure("figure5", "Figure 5", finding, text, lambda: draw(r))


def draw(r: Results) -> "Drawing":
    """Draw slow motions above, fast ones below, the full scale left and the zoom right."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 6.2), layout="constrained")
    grid = figure.subplots(2, 2, sharex=True)
    for row, motions in zip(grid, (MOTIONS[:5], MOTIONS[5:]), strict=True):
        kept = (r.weights >= 0.999) & (r.weights <= 1e5)
        top = 1.15 * max(np.rad2deg(r.rmsae(m)[kept]).max() for m in motions)
        for axes, limit in zip(row, (100.0, top), strict=True):
            axes.axvspan(10, 1e5, color="#eef3f7", zorder=0)
            for m in motions:
                axes.plot(r.weights, np.rad2deg(r.rmsae(m)), color=MOTION_COLOURS[m], lw=1.4, label=f"motion {m}")
            for m in set(motions) & set(r.authors):
                errors = np.rad2deg(rmsae_over(r.authors[m]))
                label = f"motion {m}, authors' code"
                axes.plot(r.authors_weights, errors, "o--", color=MOTION_COLOURS[m], lw=0.9, ms=3.5, label=label)
            axes.set(xscale="log", ylim=(0, limit), xlim=(r.weights[0], r.weights[-1]))
            plain(axes)
        row[0].set_ylabel("RMSAE, deg")
        row[0].axhline(90, color=QUIET, lw=0.8, ls=":")
        row[0].legend(loc="center left", frameon=False, title="slow" if motions[0] == 3 else "fast")
    for axes in grid[1]:
        axes.set_xlabel("$w_0$, weight of the gyroscope over that of the accelerometer")
    grid[0, 0].annotate("10 to 100,000", (1e3, 96), ha="center", va="top", fontsize=8, color="#55606a")
    grid[0, 1].set_title("zoomed in", fontsize=10)
    return figure
