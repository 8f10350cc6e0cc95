"""Figure 4: MrVS in a sliding window, by the size of the window."""

from typing import TYPE_CHECKING, Any

from imubench.reproduce.arve.experiments import SETUPS
from imubench.reproduce.arve.results import Results
from imubench.reproduce.arve.settings import LIMIT, WINDOW, WINDOWS
from imubench.reproduce.arve.style import LIMIT_COLOUR, PRINTED, QUIET, plain
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

MEAN, WORST = "#1f6fb4", "#9cc3e4"
OTHERS = {"late": "#2e8b57", "untold-one-sided": "#c8641e", "flat": "#1f6fb4"}


def exhibit(r: Results) -> Figure:
    """Return figure 4."""
    mean = 1e3 * r.windows["mean"][WINDOWS.index(WINDOW)]
    flat = 1e3 * r.setups["flat"]["mean"][WINDOWS.index(WINDOW)]
    finding = (
        f"Windows of 45 samples are {mean:.2g} mm off on average, not 17.6: sensor noise cannot make figure 4; a "
        f"motion nearly in a plane with a one-sided w' comes near its means ({flat:.1f} mm)"
    )
    text = (
        f"|dr| of MrVS in a sliding window, constant r, mean and largest of {r.settings.runs} runs. Left: the paper's "
        "text. Right: three other readings of it, solid the mean, dotted the largest; the table below has them all. "
        "Violet is what the paper prints."
    )
    return Figure("figure4", "Figure 4", finding, text, lambda: draw(r))


def draw(r: Results) -> "Drawing":
    """Draw the paper's axes, and the other readings beside them."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.bar(WINDOWS, 1e3 * r.windows["max"], width=3.6, color=WORST, label="largest")
    left.bar(WINDOWS, 1e3 * r.windows["mean"], width=3.6, color=MEAN, label="mean")
    left.set_title("as the text has it", fontsize=11)
    left.set_ylim(0, 45)
    for name, colour in OTHERS.items():
        right.plot(WINDOWS, 1e3 * r.setups[name]["mean"], color=colour, label=SETUPS[name].label)
        right.plot(WINDOWS, 1e3 * r.setups[name]["max"], color=colour, ls=":")
    right.plot(WINDOWS, 1e3 * r.windows["mean"], color=QUIET, label="as the text has it")
    right.set_yscale("log")
    right.set_ylim(0.3, 2e5)  # room for the legend
    right.set_yticks([1, 10, 100, 1000], ["1", "10", "100", "1000"])
    right.set_title("other readings", fontsize=11)
    for axes in (left, right):
        axes.axhline(1e3 * LIMIT, color=LIMIT_COLOUR, lw=1.2, label="upper limit, 20 mm")
        _printed(axes)
        axes.set_xlabel("window size (number of samples)")
        axes.set_ylabel("|Δr|, mm")
        axes.set_xlim(0, 103)
        axes.legend(fontsize=8, frameon=False, loc="upper right")
        plain(axes)
    left.annotate("printed: largest > 100 mm", (45, 44), ha="center", va="top", fontsize=8, color=PRINTED)
    return figure


def _printed(axes: Any) -> None:
    """Mark what section IV-C says of figure 4."""
    axes.plot([45], [17.6], "D", color=PRINTED, ms=6, label="printed mean", ls="none")
    for x, y, marker, label in ((45, 100, "^", "printed largest, > 100 mm"), (80, 10, "v", "printed mean, < 10 mm")):
        if y < axes.get_ylim()[1]:
            axes.plot([x], [y], marker, color=PRINTED, ms=7, mfc="white", label=label, ls="none")
