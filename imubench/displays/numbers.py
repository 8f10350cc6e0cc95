"""Figures in the units in which people read them."""

import numpy as np

READ_IN = {"rad": (180 / np.pi, "deg"), "m": (1e3, "mm")}


def told(value: float, unit: str) -> tuple[float, str]:
    """Return a figure and its unit for people: degrees for rad, millimetres for m, others as they are."""
    factor, shown = READ_IN.get(unit, (1.0, unit))
    return factor * value, shown
