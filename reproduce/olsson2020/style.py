"""How the figures look: colours, axes, the boundaries of motions."""

from typing import Any

import numpy as np

from imubench.scenarios.olsson2020.sequences import Section

SEGMENT1, SEGMENT2 = "#1f6fb4", "#c8641e"
ERROR, LOCAL, GLOBAL = "#c0392b", "#1f6fb4", "#2e8b57"
SIZE_COLOURS = {0: "#111111", 1000: "#1f6fb4", 500: "#2e8b57", 250: "#c8641e", 125: "#c03a87"}
MOTION_COLOURS = {3: "#1f6fb4", 4: "#5aa9d6", 5: "#2e8b57", 6: "#8cbf5a", 7: "#c0392b"}
MOTION_COLOURS |= {m + 7: colour for m, colour in MOTION_COLOURS.items()}
QUIET = "#9aa3ab"


def size_name(n_max: int) -> str:
    """Return how a legend names N_max."""
    return "all samples" if n_max == 0 else f"N_max = {n_max}"


def mark_sections(axes: Any, sections: tuple[Section, ...], numbers: bool = True) -> None:
    """Draw the boundaries of the motions as vertical dashed lines, with their numbers on top."""
    for section in sections[1:]:
        axes.axvline(section.start, color=QUIET, lw=0.6, ls=(0, (4, 3)), zorder=0)
    if not numbers:
        return
    narrow = 0.03 * sections[-1].end
    raised = False
    for section in sections:
        raised = section.end - section.start < narrow and not raised  # two short ones side by side would run together
        axes.annotate(
            str(section.motion),
            ((section.start + section.end) / 2, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 8 if raised else 2),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=7,
            color="#55606a",
        )


def degrees_axis(axes: Any, low: float = 2e-3, high: float = 250.0) -> None:
    """Give an axes a logarithmic scale of degrees."""
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    ticks = [t for t in (0.001, 0.01, 0.1, 1, 10, 100) if low <= t <= high]
    axes.set_yticks(ticks, [f"{t:g}" for t in ticks])
    axes.minorticks_off()
    plain(axes)


def plain(axes: Any) -> None:
    """Take away what carries no data."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="#e6e9ec", lw=0.6)
    axes.set_axisbelow(True)


def clipped(errors: Any, low: float = 2e-3) -> Any:
    """Return degrees of angles in rad, no smaller than the bottom of the axis."""
    return np.maximum(np.rad2deg(errors), low)
