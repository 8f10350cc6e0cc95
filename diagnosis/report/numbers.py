"""Numbers as a person reads them: a unit of the laboratory, as many digits as are known."""

from collections.abc import Iterator

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.report import PAGE
from imubench.diagnosis.result import Parameter

LABORATORY = {  # SI -> factor and unit in the report
    "rad": (180 / np.pi, "deg"),
    "rad/s": (180 / np.pi, "deg/s"),
    "rad/s^2": (180 / np.pi, "deg/s^2"),
    "m": (1e3, "mm"),
    "m/rad": (1e3 * np.pi / 180, "mm/deg"),
}
SMALL_TIMES = (1e3, "ms")
COMPONENT_NAMES = {  # number of components -> their names
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


def printed(unit: str) -> tuple[float, str]:
    """Return factor and name of a unit as it is drawn or said: mm, deg/s, m/s²."""
    factor, name = shown(1.0, unit)
    return factor, name.replace("^2", "²")


NOT_SHOWN = "not shown by this recording"


def rows(name: str, p: Parameter) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, value, 95 % interval and unit of each component of a parameter; no number that is not seen."""
    values, stds = np.atleast_1d(p.value).ravel(), np.atleast_1d(p.std).ravel()
    factor, unit = _common(values, p.unit)
    labels = COMPONENT_NAMES.get(values.size, tuple(str(i + 1) for i in range(values.size)))
    for label, value, std, seen in zip(labels, values * factor, stds * factor, numbers_seen(p), strict=True):
        called = name.replace("_", " ") + (f" {label}" if values.size > 1 else "")
        if not seen:
            yield called, "", NOT_SHOWN, unit
            continue
        digits = decimals(std if std > 0 else value)
        low, high = value - 1.96 * std, value + 1.96 * std
        interval = f"{fixed(low, digits)} to {fixed(high, digits)}" if std > 0 else "exact"
        yield called, fixed(value, digits), interval, unit


def numbers_seen(p: Parameter) -> list[bool]:
    """Return whether each number of a parameter is seen: not one that lies mostly along directions that are not."""
    if p.fixed is None:
        return [True] * p.value.size
    return [bool(np.sum(row**2) < PAGE.most) for row in p.fixed.unseen]


def size(name: str, p: Parameter) -> str:
    """Return the length of a parameter's vector with its 95 % interval, and how far it is from zero, in a sentence.

    In the directions that are seen: with P the projection on these, v = P x and C = P S P of the covariance S, the
    length |v| has the standard deviation sqrt(v^T C v) / |v|, and v is sqrt(v^T C^+ v) standard deviations from zero.
    Empty for a single number, where zeros are not none (frequencies), and where the covariance is not known.
    """
    values = p.value.ravel()
    if p.fixed is None or not p.fixed.from_none or values.size < 2:
        return ""
    seen = np.eye(values.size) - p.fixed.unseen @ p.fixed.unseen.T
    vector, covariance = seen @ values, seen @ p.fixed.covariance @ seen
    length = float(np.linalg.norm(vector))
    if not length > 0 or p.fixed.unseen.shape[1] >= values.size:
        return ""
    inverse = np.linalg.pinv(covariance, rcond=1e-9, hermitian=True)
    away = float(np.sqrt(max(float(vector @ inverse @ vector), 0.0)))
    std = float(np.sqrt(max(float(vector @ covariance @ vector), 0.0))) / length
    factor, unit = _common(values, p.unit)
    digits = decimals(factor * std) if std else decimals(factor * length)
    low, high = (fixed(factor * max(length + s * 1.96 * std, 0.0), digits) for s in (-1, 1))
    part = ", in the directions that are seen," if p.fixed.unseen.shape[1] else ""
    far = f"{away:.1f}" if away < 10 else f"{away:.0f}"
    return (
        f"The {name.replace('_', ' ')} as a whole{part} is {fixed(factor * length, digits)} {unit} long "
        f"({low} to {high}, 95 %), {far} standard deviations from none."
    ).replace("  ", " ")


def _common(values: Array, unit: str) -> tuple[float, str]:
    """Return one factor and unit for all components."""
    largest = float(np.abs(values).max(initial=0.0))
    if unit == "s" and 0 < largest < 0.5:
        return SMALL_TIMES
    factor, name = LABORATORY.get(unit, (1.0, unit))
    return factor, "" if name == "1" else name.replace("^2", "²").replace("^3", "³")


def decimals(std: float) -> int:
    """Return how many decimals show a number whose uncertainty is `std` to two digits."""
    return int(np.clip(1 - np.floor(np.log10(abs(std))), 0, 9)) if std else 0


def fixed(value: float, digits: int) -> str:
    """Return a number with so many decimals and a proper minus sign."""
    text = f"{value:.{digits}f}"
    return text.replace("-", "−") if float(text) else text.lstrip("-")


def brief(value: float) -> str:
    """Return a size to three digits, two where it is below 1: 69.4, 0.17, 0.0025."""
    if not value:
        return "0"
    power = int(np.floor(np.log10(abs(value)) + 1e-9))
    return fixed(value, int(np.clip((2 if power >= 0 else 1) - power, 0, 9)))
