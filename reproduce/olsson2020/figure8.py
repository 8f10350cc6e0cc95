"""Figure 8: what the method says about its uncertainty, beside its errors, and when Algorithm 4 accepts."""

from typing import TYPE_CHECKING

import numpy as np

from imubench.reproduce.olsson2020.results import Results
from imubench.reproduce.olsson2020.settings import E_MAX, N_MINS, SEQUENCES
from imubench.reproduce.olsson2020.style import ERROR, GLOBAL, LOCAL, clipped, degrees_axis, mark_sections
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

SHOWN = 0  # the run that is drawn


def exhibit(r: Results) -> Figure:
    """Return figure 8."""
    rates = {n: [100 * r.runs[name].success(E_MAX, n) for name in SEQUENCES] for n in N_MINS}
    listed = {n: ", ".join("none accepted" if np.isnan(x) else f"{x:.0f}" for x in rates[n]) for n in N_MINS}
    wrong = [name[-1] for name, rate in zip(SEQUENCES, rates[10], strict=True) if not rate >= 100]
    finding = (
        "With n_min = 10 every accepted estimate is right, in all four sequences"
        if not wrong
        else f"With n_min = 10 Algorithm 4 accepts wrong estimates in sequence {', '.join(wrong)}"
    )
    text = (
        f"One of {r.settings.runs} runs, N_max = 1000. Right estimates among the accepted, in %, for sequences 1 to 4: "
        f"n_min = 3: {listed[3]} (paper: 8, 81, 100, 0); n_min = 10: {listed[10]} (paper: 100 in all). "
        "Vertical lines: where Algorithm 4 accepts, dashed for n_min = 3, solid for n_min = 10. Local uncertainty "
        "is mu + 2 sigma of an axis, global the largest deviation between the last 10 estimates; both must be "
        "under E_max."
    )
    return Figure("figure8", "Figure 8", finding, text, lambda: draw(r))


def draw(r: Results) -> "Drawing":
    """Draw one panel a sequence."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 12), layout="constrained")
    for axes, name, letter in zip(figure.subplots(len(SEQUENCES), 1), SEQUENCES, "abcd", strict=True):
        run = r.runs[name]
        time = np.arange(1, len(run.seqad) + 1)
        for i, style in enumerate(("-", ":")):
            error, local = clipped(run.deviation[:, SHOWN, i]), clipped(run.local[:, SHOWN, i])
            axes.plot(time, local, style, color=LOCAL, lw=1.0, label=f"local uncertainty of $j_{i + 1}$")
            axes.plot(time, error, style, color=ERROR, lw=1.2, label=f"error of $j_{i + 1}$")
        worst = clipped(run.global_uncertainty(10)[:, SHOWN])
        axes.plot(time, worst, color=GLOBAL, lw=1.4, label="global uncertainty, $n_{min}$ = 10")
        axes.axhline(np.rad2deg(E_MAX), color="black", ls="--", lw=0.8, label="$E_{max}$ = 3 deg")
        for n_min, dashes in zip(N_MINS, ("--", "-"), strict=True):
            at = int(run.accepted(E_MAX, n_min)[SHOWN])
            if at >= 0:
                axes.axvline(at + 1, color="black", ls=dashes, lw=1.5, label=f"accepted, $n_{{min}}$ = {n_min}")
        degrees_axis(axes)
        axes.set_xlim(0, len(run.seqad))
        axes.set_ylabel(f"({letter}) sequence {name[-1]}\nangle, deg")
        mark_sections(axes, r.sections(name))
    axes.set_xlabel("time, s")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=5, frameon=False)
    return figure
