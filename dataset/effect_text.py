"""Effects as they are typed on a command line: `soft_mount@imu2:frequency=9,damping_ratio=0.05..0.2`."""

from typing import Any

from imubench.dataset.effect_ranges import EffectRange, parse_effect
from imubench.errors import InputError, shown

LISTS = ("channels",)
"""Keys that take names: `channels=gyro+accel`."""


def effect_from_text(text: str) -> EffectRange:
    """Return an effect with its place and what its numbers are drawn from.

    Args:
        text: NAME@PLACE:KEY=VALUE,...; of a spec's `[[effect]]` (docs/datasets.md), in one line. A value is a number,
            LOW..HIGH, or a name; several names are joined by `+`. Without a place the effect comes to all that it can
            come to, and what is not given is drawn as wide as a diagnosis expects it.

    Raises:
        InputError: another form; a name, a place or a key that is unknown; a number out of bounds.
    """
    head, _, tail = text.partition(":")
    name, at, place = head.partition("@")
    table: dict[str, Any] = {"name": name.strip()}
    if at:
        table["at"] = place.strip()
    for pair in filter(None, (part.strip() for part in tail.split(","))):
        key, equals, value = (part.strip() for part in pair.partition("="))
        if not equals or not key or not value:
            several = "" if equals else "; one VALUE or LOW..HIGH is for all numbers of a KEY"
            raise InputError(f"--effect {shown(text)}: expected NAME@PLACE:KEY=VALUE,..., got '{pair}'{several}")
        if key in ("name", "at", "probability") or key in table:
            raise InputError(f"--effect {shown(text)}: expected each number of the effect once, got '{key}'")
        table[key] = value.split("+") if key in LISTS else _value(value)
    return parse_effect(table, f"--effect {table['name'] or shown(text)}")


def _value(text: str) -> Any:
    """Return a number, a range or a name."""
    low, dots, high = text.partition("..")
    try:
        return [float(low), float(high)] if dots else float(text)
    except ValueError:
        return text
