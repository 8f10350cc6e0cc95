"""How a map shows what cannot be played: hatched ground, and a cross at each point."""

from collections.abc import Iterable
from typing import Any

from numpy.typing import ArrayLike

GROUND: dict[str, Any] = {"facecolor": "#eceeef", "hatch": "////", "edgecolor": "#c3c9cd", "lw": 0}
CROSS: dict[str, Any] = {"color": "#8b2b20", "mew": 1.8}

Box = tuple[float, float, float, float]
"""Left, right, low, high, in the axes' own numbers."""


def hatch(axes: Any, boxes: Iterable[Box], zorder: float = 0) -> None:
    """Draw the ground of what cannot be played."""
    from matplotlib.patches import Rectangle

    for left, right, low, high in boxes:
        axes.add_patch(Rectangle((left, low), right - left, high - low, zorder=zorder, **GROUND))


def cross(axes: Any, x: ArrayLike, y: ArrayLike, size: float = 7, on_colours: bool = False) -> Any:
    """Draw a cross at each point that cannot be played, and return it for a legend.

    Args:
        axes: of Matplotlib.
        x: (n,) where the points are.
        y: (n,)
        size: in points.
        on_colours: with a white edge, which is seen on any of them.
    """
    if on_colours:
        axes.plot(x, y, "x", ms=size + 2, zorder=4, clip_on=False, color="white", mew=CROSS["mew"] + 2)
    (crosses,) = axes.plot(x, y, "x", ms=size, zorder=4, clip_on=False, **CROSS)
    return crosses


def ground_of_legend() -> Any:
    """Return a piece of the ground for a legend."""
    from matplotlib.patches import Patch

    return Patch(**GROUND)
