"""How the figures look: the paper's colours for the components of r, and axes without ornament."""

from typing import Any

TRUTH, LIMIT_COLOUR, PRINTED = "#111111", "#c0392b", "#7a3fa0"
X, Y, Z = "#1f6fb4", "#c0392b", "#d99a1c"
COMPONENTS = ((X, "r_x"), (Y, "r_y"), (Z, "r_z"))
ARVE_D, ARVE = "#1f6fb4", "#c8641e"
DISTANCE, LENGTH, ANGLE = "#1f6fb4", "#2e8b57", "#d9822b"
QUIET = "#9aa3ab"


def plain(axes: Any, grid: str = "y") -> None:
    """Take away what carries no data."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis=grid, color="#e6e9ec", lw=0.6)
    axes.set_axisbelow(True)


def spread(values: Any, least: float = 1.0) -> tuple[float, float]:
    """Return limits that hold all values, with some room, and at least `least` apart."""
    low, high = float(min(values)), float(max(values))
    room = max(0.08 * (high - low), (least - (high - low)) / 2)
    return low - room, high + room
