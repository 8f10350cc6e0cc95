"""Stretches of time, and the samples that lie in them."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array

Window = tuple[float, float]
"""From, to, s."""

Windows = tuple[Window, ...]


def covered(time: Array, windows: Iterable[Window]) -> NDArray[np.bool_]:
    """Return which of some times (n,) lie in one of the windows, their ends among them."""
    out = np.zeros(len(time), dtype=bool)
    for start, end in windows:
        out |= (time >= start) & (time <= end)
    return out


def cut_out(windows: Iterable[Window], gone: Iterable[Window]) -> tuple[Window, ...]:
    """Return what is left of some windows where others are cut out of them."""
    out = list(windows)
    for a, b in gone:
        parts = [piece for start, end in out for piece in ((start, min(end, a)), (max(start, b), end))]
        out = [(start, end) for start, end in parts if end > start]
    return tuple(dict.fromkeys(out))


__all__ = ["Window", "Windows", "covered", "cut_out"]
