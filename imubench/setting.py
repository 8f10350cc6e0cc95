"""A number that decides something, as a field of a frozen record that knows its unit, its reason and its source."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

Value = TypeVar("Value")

SOURCES: Mapping[str, str] = {
    "statistics": "follows from how chance distributes",
    "physics": "of bodies, hands and sensors",
    "data sheet": "of the sensors that it names",
    "numerics": "of rounding, steps and convergence",
    "time": "of processor time and memory",
    "trials": "set on simulated and real recordings that the reason names; another corpus may move it",
    "judgement": "chosen, with no derivation on record",
    "convention": "a definition, or a choice of what is shown or repeated",
}
"""Where a value comes from."""


@dataclass(frozen=True)
class Setting:
    """A field of a record as a row of the reference."""

    name: str
    value: object
    unit: str
    reason: str
    source: str


def setting(value: Value, unit: str, reason: str, source: str) -> Value:
    """Return a dataclass field with a default that says where it comes from.

    Args:
        value: the default.
        unit: SI, or of what it is a part or a multiple.
        reason: what the number is of, and why it is so large.
        source: a key of `SOURCES`.

    Raises:
        ValueError: for another source.
    """
    if source not in SOURCES:
        raise ValueError(f"unknown source '{source}'; known: {', '.join(SOURCES)}")
    return field(default=value, metadata={"unit": unit, "reason": reason, "source": source})


def settings_of(record: Any) -> Iterator[Setting]:
    """Yield the fields of a record that were made by `setting`, in their order."""
    for f in fields(record):
        if "source" in f.metadata:
            yield Setting(f.name, getattr(record, f.name), *(f.metadata[key] for key in ("unit", "reason", "source")))
