"""Figure 7: a varying r over the test, by ArVE and ArVE_d."""

from typing import TYPE_CHECKING

import numpy as np

from imubench.reproduce.arve.results import Results
from imubench.reproduce.arve.style import COMPONENTS, TRUTH, plain, spread
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

TITLES = {"arve": "ArVE", "arve-d": "ArVE_d"}


def exhibit(r: Results) -> Figure:
    """Return figure 7."""
    lags = {name: lag(r, name) for name in TITLES}
    finding = (
        f"Both filters follow r; ArVE comes {1e3 * lags['arve']:.0f} ms late, ArVE_d, which knows its rate, "
        f"{1e3 * lags['arve-d']:.0f} ms"
    )
    text = (
        "Run 1 of the varying r: the truth in black, estimates in colour, from the 60th sample on. One row a "
        "component, each with its own scale (the paper draws all three in one). How late: the shift that brings the "
        "estimates of all runs nearest to the truth."
    )
    return Figure("figure7", "Figure 7", finding, text, lambda: draw(r))


def lag(r: Results, name: str) -> float:
    """Return by how many s the estimates of a filter are best shifted to meet the truth."""
    first, track, truth = int(r.varying["first"]), r.varying[f"r {name}"], r.varying["truth"]
    shifts = range(20)
    left = [np.square(track[:, k:] - truth[first : len(truth) - k]).mean() for k in shifts]
    return float(np.argmin(left) * (r.varying["time"][1] - r.varying["time"][0]))


def draw(r: Results) -> "Drawing":
    """Draw ArVE on the left, ArVE_d on the right."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 6), layout="constrained")
    panels = figure.subplots(3, 2, sharex=True, sharey="row")
    time, first, truth = r.varying["time"], int(r.varying["first"]), 1e3 * r.varying["truth"]
    for column, (name, title) in enumerate(TITLES.items()):
        track = 1e3 * r.varying[f"r {name}"][0]
        for i, (colour, component) in enumerate(COMPONENTS):
            axes = panels[i, column]
            axes.plot(time, truth[:, i], color=TRUTH, lw=1.0, label="truth")
            axes.plot(time[first:], track[:, i], color=colour, lw=1.2, label=title)
            axes.set_ylim(*spread([*truth[:, i], *track[:, i]]))
            axes.set_ylabel(f"${component}$, mm")
            axes.tick_params(labelleft=True)
            axes.legend(fontsize=8, frameon=True, framealpha=0.9, edgecolor="none", loc="lower right", ncols=2)
            plain(axes)
        panels[0, column].set_title(title, fontsize=11)
        panels[2, column].set_xlabel("time, s")
        panels[2, column].set_xlim(0, time[-1])
    return figure
