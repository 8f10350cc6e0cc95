"""What every number and name in a diagnosis is checked for when it is made."""

import re

import numpy as np

from imubench.errors import InputError, unknown
from imubench.recording import OWN_IMUS

PLACES = re.compile(r"imu[12]|joint|body|world|encoder|pose[1-9]")

Pair = tuple[float, float]


def finite(value: object, name: str) -> float:
    """Return a number; `InputError` where it is none or not finite."""
    number = isinstance(value, int | float | np.floating | np.integer) and not isinstance(value, bool)
    if not number or not np.isfinite(value):  # type: ignore[call-overload]
        raise InputError(f"{name}: expected a finite number, got {value!r}")
    return float(value)  # type: ignore[arg-type]


def within(value: float, low: float, high: float, name: str) -> None:
    """Raise `InputError` where a number is not finite or not from `low` to `high`."""
    if not low <= finite(value, name) <= high:
        raise InputError(f"{name}: expected a number from {low:g} to {high:g}, got {value:g}")


def span(pair: object, name: str) -> Pair:
    """Return two numbers, the lower one first; `InputError` where they are not that."""
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise InputError(f"{name}: expected two numbers, got {pair!r}")
    low, high = (finite(x, name) for x in pair)
    if high < low:
        raise InputError(f"{name}: expected the lower end first, got {low:g} and {high:g}")
    return low, high


def place(at: str, name: str) -> None:
    """Raise `InputError` for a place that no rig has."""
    if not isinstance(at, str) or not PLACES.fullmatch(at):
        raise unknown(name, at, (*OWN_IMUS, "joint", "body", "world", "encoder", "pose1"))
