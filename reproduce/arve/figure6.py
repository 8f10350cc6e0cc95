"""Figure 6: ArVE_d by how many samples make r0."""

from typing import TYPE_CHECKING

from imubench.reproduce.arve.results import UNITS, Results
from imubench.reproduce.arve.settings import INITIALS
from imubench.reproduce.arve.style import ANGLE, DISTANCE, LENGTH, PRINTED, plain
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

PANELS = ((DISTANCE, "|Δr|, mm"), (LENGTH, "Δ|r|, mm"), (ANGLE, "γ, deg"))


def exhibit(r: Results) -> Figure:
    """Return figure 6."""
    low, high = (1e3 * f(r.initials[..., 0].mean(axis=1)) for f in (min, max))
    finding = (
        f"With r0 from 20 samples or from 140, ArVE_d is {low:.2f} to {high:.2f} mm off: 20 would do, and the error "
        "is a quarter of the printed 2 mm"
    )
    text = (
        f"Errors of ArVE_d on a constant r over all samples that have an answer. Bars: mean of {r.settings.runs} runs; "
        "lines: from the best run to the worst. The paper's bars fall until 60 samples and stay at about 2 mm from "
        "there on; what they are before, its text does not say."
    )
    return Figure("figure6", "Figure 6", finding, text, lambda: draw(r))


def draw(r: Results) -> "Drawing":
    """Draw three rows of bars with their ranges."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 5.4), layout="constrained")
    rows = figure.subplots(3, 1, sharex=True)
    for k, (axes, (colour, label)) in enumerate(zip(rows, PANELS, strict=True)):
        errors = r.initials[..., k] * UNITS[k]
        mean = errors.mean(axis=1)
        ranges = [mean - errors.min(axis=1), errors.max(axis=1) - mean]
        axes.bar(INITIALS, mean, width=11, color=colour)
        axes.errorbar(INITIALS, mean, ranges, fmt="none", ecolor="#333333", elinewidth=1.2, capsize=4)
        axes.set_ylabel(label)
        axes.set_ylim(0, None)
        plain(axes)
    rows[0].axhline(2.0, xmin=2.4 / 7, color=PRINTED, ls="--", lw=1.2, label="printed: about 2 mm from 60 samples on")
    rows[0].set_ylim(0, 2.4)
    rows[0].legend(fontsize=8, frameon=False, loc="center left")
    rows[-1].set_xlabel("number of initial samples that make r0")
    rows[-1].set_xticks(INITIALS)
    return figure
