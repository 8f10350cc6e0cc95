"""Stretches of time, and the samples that lie in them."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array

Window = tuple[float, float]
"""From, to, s."""


def covered(time: Array, windows: Iterable[Window]) -> NDArray[np.bool_]:
    """Return which of some times (n,) lie in one of the windows, their ends among them."""
    out = np.zeros(len(time), dtype=bool)
    for start, end in windows:
        out |= (time >= start) & (time <= end)
    return out


__all__ = ["Window", "covered"]
