"""The drawings of a proof: detection beside its theory, and stated confidence beside what was true."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imubench.trials.detection import LEVEL, PowerRow, power
from imubench.trials.scoring import CaseScore

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

THEORY, HERE, SOFT = "#1f6fb4", "#1e7d4f", "#9aa3ab"
FREEDOMS = (1, 3, 9)
DETECTION = (
    "Lone effects by their size over the Cramer-Rao bound: share with an alarm (dots, 95 % Wilson), the same cases by "
    f"theory (crosses), and the theoretical power of a test with {100 * LEVEL:g} % false alarms that is told what to "
    "look for, for effects of 1, 3 and 9 numbers. Ticks at the edges are single cases, seen above and missed below."
)
RELIABILITY = (
    "Findings by stated confidence: the share that is true, 95 % Wilson. On the diagonal a statement is right."
)


def detection(rows: Sequence[PowerRow], scores: Sequence[CaseScore]) -> "Canvas":
    """Return detection against strength, with theory."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4), layout="constrained")
    axes = figure.subplots()
    x = np.geomspace(0.5, 1000, 120)
    for freedom, style in zip(FREEDOMS, ("-", "--", ":"), strict=True):
        axes.plot(
            x,
            [power(v, freedom) for v in x],
            style,
            color=THEORY,
            lw=1.2,
            label=f"theory, {freedom} number{'s' if freedom > 1 else ''}",
        )
    lone = [s for s in scores if s.kind == "one" and s.strength[0] is not None]
    for s in lone:
        axes.plot(
            [float(np.clip(s.strength[0] or 0.5, 0.5, 1000))], [1.05 if s.alarm else -0.05], "|", color=SOFT, ms=9
        )
    for row in rows:
        inside = [v for s in lone if (v := s.strength[0]) is not None and row.low <= v < row.high]
        centre = float(np.clip(np.exp(np.mean(np.log(np.maximum(inside, 0.5)))), 0.5, 1000))
        _dot(axes, centre, row.hits / row.n, row.interval, row.n)
        axes.plot([centre], [row.theory], "x", color=THEORY)
    axes.set(xscale="log", xlabel="size over its Cramer-Rao bound", ylabel="share detected", ylim=(-0.1, 1.1))
    axes.legend(frameon=False, loc="center left")
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def reliability(rows: Sequence[dict[str, Any]]) -> "Canvas":
    """Return the share of true findings against their stated confidence."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 4), layout="constrained")
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], color=THEORY, lw=1.2)
    for row in rows:
        _dot(axes, row["stated"], row["true"] / row["n"], tuple(row["interval"]), row["n"])
    axes.set(xlabel="stated confidence", ylabel="share that is true", xlim=(-0.03, 1.03), ylim=(-0.03, 1.03))
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def _dot(axes: Any, x: float, share: float, interval: tuple[float, ...], n: int) -> None:
    low, high = max(share - interval[0], 0.0), max(interval[1] - share, 0.0)  # rounding puts a Wilson end at 1 - 1e-16
    axes.errorbar([x], [share], [[low], [high]], fmt="o", color=HERE, capsize=3)
    axes.annotate(f"n={n}", (x, share), xytext=(6, -12), textcoords="offset points", fontsize=8, color=SOFT)
