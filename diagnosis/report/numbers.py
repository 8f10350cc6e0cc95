"""Numbers as a person reads them: a unit of the laboratory, as many digits as are known."""

from collections.abc import Iterator

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.result import Parameter

LABORATORY = {  # SI -> factor and unit in the report
    "rad": (180 / np.pi, "deg"),
    "rad/s": (180 / np.pi, "deg/s"),
    "rad/s^2": (180 / np.pi, "deg/s^2"),
    "m": (1e3, "mm"),
    "m/rad": (1e3 * np.pi / 180, "mm/deg"),
}
SMALL_TIMES = (1e3, "ms")
NAMES = {  # number of components -> their names
    3: ("x", "y", "z"),
    6: ("xy", "xz", "yx", "yz", "zx", "zy"),
    9: ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"),
}


def shown(value: float, unit: str) -> tuple[float, str]:
    """Return a number in the laboratory's unit."""
    if unit == "s" and 0 < abs(value) < 0.5:
        return value * SMALL_TIMES[0], SMALL_TIMES[1]
    factor, name = LABORATORY.get(unit, (1.0, unit))
    return value * factor, "" if name == "1" else name


def rows(name: str, p: Parameter) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, value, 95 % interval and unit of each component of a parameter."""
    values, stds = np.atleast_1d(p.value).ravel(), np.atleast_1d(p.std).ravel()
    factor, unit = _common(values, p.unit)
    labels = NAMES.get(values.size, tuple(str(i + 1) for i in range(values.size)))
    for label, value, std in zip(labels, values * factor, stds * factor, strict=True):
        digits = decimals(std if std > 0 else value)
        low, high = value - 1.96 * std, value + 1.96 * std
        yield (
            name.replace("_", " ") + (f" {label}" if values.size > 1 else ""),
            fixed(value, digits),
            f"{fixed(low, digits)} to {fixed(high, digits)}" if std > 0 else "exact",
            unit,
        )


def _common(values: Array, unit: str) -> tuple[float, str]:
    """Return one factor and unit for all components."""
    largest = float(np.abs(values).max(initial=0.0))
    if unit == "s" and 0 < largest < 0.5:
        return SMALL_TIMES
    factor, name = LABORATORY.get(unit, (1.0, unit))
    return factor, "" if name == "1" else name


def decimals(std: float) -> int:
    """Return how many decimals show a number whose uncertainty is `std` to two digits."""
    return int(np.clip(1 - np.floor(np.log10(abs(std))), 0, 9)) if std else 0


def fixed(value: float, digits: int) -> str:
    """Return a number with so many decimals and a proper minus sign."""
    text = f"{value:.{digits}f}"
    return text.replace("-", "−") if float(text) else text.lstrip("-")
