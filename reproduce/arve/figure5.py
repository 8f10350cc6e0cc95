"""Figure 5: r over the first 2.5 s by MrVS in windows, and by ArVE_d from zeros."""

from typing import TYPE_CHECKING

import numpy as np

from imubench.reproduce.arve.results import Results
from imubench.reproduce.arve.settings import WINDOW
from imubench.reproduce.arve.style import COMPONENTS, QUIET, TRUTH, plain
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

SECONDS = 2.5


def exhibit(r: Results) -> Figure:
    """Return figure 5."""
    worst = 1e3 * np.linalg.norm(r.windows["r"] - r.windows["truth"][0], axis=-1).max()
    finding = (
        f"From zeros ArVE_d is within 20 mm after {r.settled():.2f} s on every run; MrVS in windows never strays by "
        f"more than {worst:.1f} mm on this one, where the paper saw it fail"
    )
    text = (
        "Run 1 of the constant r. a) MrVS, windows of 45 samples, drawn at their last sample. b) ArVE_d from "
        f"r0 = (0, 0, 0). Grey bands: the 10 % of samples with the smallest |w|, here {r.windows['rate'].min():.2f} "
        "rad/s and more; the paper circles instants at which it is negligible, and an ellipse has none."
    )
    return Figure("figure5", "Figure 5", finding, text, lambda: draw(r))


def draw(r: Results) -> "Drawing":
    """Draw both panels."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    time, rate = r.windows["time"], r.windows["rate"]
    slow = rate < np.quantile(rate, 0.1)
    for axes, track, start, title in (
        (left, r.windows["r"], WINDOW + 1, "a) MrVS, windows of 45 samples"),
        (right, r.blind["r"], 0, "b) ArVE_d from r0 = 0"),
    ):
        axes.fill_between(time, 0, 1, where=slow, transform=axes.get_xaxis_transform(), color="#eceff1", lw=0)
        for i, (colour, name) in enumerate(COMPONENTS):
            axes.axhline(1e3 * r.windows["truth"][0, i], color=TRUTH, lw=1.0, label="truth" if i == 0 else None)
            axes.plot(time[start:], 1e3 * track[:, i], color=colour, lw=1.4, label=f"${name}$")
        axes.set_title(title, fontsize=11)
        axes.set_xlabel("time, s")
        axes.set_xlim(0, SECONDS)
        axes.tick_params(labelleft=True)
        plain(axes)
    left.axvspan(0, time[WINDOW + 1], color="none", ec=QUIET, hatch="//", alpha=0.4, lw=0)
    left.text(time[WINDOW + 1] / 2, 100, "first window\nnot full", ha="center", fontsize=8, color="#55606a")
    left.set_ylabel("r, mm")
    right.legend(fontsize=8, frameon=False, loc="center right", ncols=2)
    return figure
