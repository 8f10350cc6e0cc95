"""Figures in the units in which people read them."""

from imubench.units import SHOWN


def told(value: float, unit: str) -> tuple[float, str]:
    """Return a figure and its unit for people: degrees for rad, millimetres for m, others as they are."""
    shown, factor = SHOWN.get(unit, (unit, 1.0))
    return factor * value, shown
