"""Known datasets and files into format 1: to add one, write its module and add its line below.

A converter returns objects; whoever called it writes them.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path

from imubench.convert import broad, csv, diodem, multiarm
from imubench.convert.converter import Converted, Converter, Option
from imubench.entry_points import CONVERTERS as POINTS
from imubench.entry_points import blamed, from_package, offered, origin
from imubench.errors import InputError, shown, unknown

CONVERTERS: dict[str, Converter] = {
    "diodem": diodem.CONVERTER,
    "broad": broad.CONVERTER,
    "multiarm": multiarm.CONVERTER,
    "csv": csv.CONVERTER,
}


def find_converter(name: str) -> Converter:
    """Return the converter of a format, ours or an installed package's; `InputError` lists those that are known."""
    if name in CONVERTERS:
        return CONVERTERS[name]
    found = from_package(POINTS, name, "format", Converter)
    if not isinstance(found, Converter):
        raise unknown("format", name, known_converters())
    return replace(found, convert=_blamed(name, found.convert))


def _blamed(name: str, convert: Callable[..., list[Converted]]) -> Callable[..., list[Converted]]:
    """Return a stranger's conversion whose errors are told as theirs."""

    @wraps(convert)  # its signature has the options' defaults
    def converted(source: Path, **options: object) -> list[Converted]:
        with blamed(f"format '{name}'"):
            found = convert(source, **options)
        if not isinstance(found, list) or not all(isinstance(one, Converted) for one in found):
            raise InputError(f"format '{name}': expected a list of Converted, got {shown(found)}")
        return found

    return converted


def known_converters() -> dict[str, str]:
    """Return the formats that can be converted, each with one line about it; no package is imported for that."""
    outside = {name: origin(points) for name, points in offered(POINTS).items()}
    return {**outside, **{name: c.summary for name, c in CONVERTERS.items()}}


__all__ = ["CONVERTERS", "Converted", "Converter", "Option", "find_converter", "known_converters"]
