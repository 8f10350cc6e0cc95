"""What TOML and JSON have in common: values within values, bounded in depth, number and size."""

import math
from typing import Any

from imubench.errors import InputError, shortened, shown
from imubench.inputs.limits import DEPTH, ENTRIES, INTEGER, SIZE


def checked(content: Any, where: str, finite: bool = True) -> Any:
    """Return parsed content whose depth, number of values and numbers are within the limits.

    Args:
        content: dictionaries, lists and plain values.
        where: the file, for the message.
        finite: whether a number that is not finite, as `1e400` is not, or beyond `SIZE` is refused.

    Raises:
        InputError: deeper than `DEPTH`, more than `ENTRIES` values, a whole number beyond 64 bits, a number that is
            not finite, or a control character in a text or key other than a line end or tab.
    """
    level: list[tuple[str, Any]] = [("", content)]
    seen = 0
    for depth in range(DEPTH + 1):
        seen += len(level)
        if seen > ENTRIES:
            raise InputError(f"{where}: expected at most {ENTRIES:,} values, got more")
        below: list[tuple[str, Any]] = []
        for at, value in level:
            if isinstance(value, dict):
                for key, item in value.items():
                    _check_text(key, f"{where}, key {shown(key)}")
                    below.append((f"{at}.{key}" if at else key, item))
            elif isinstance(value, list):
                below += [(f"{at}[{i}]", item) for i, item in enumerate(value)]
            else:
                _check_plain(value, f"{where}, key '{shortened(at, 60)}'" if at else where, finite)
        if not below:
            return content
        if depth == DEPTH:
            break
        level = below
    raise InputError(f"{where}: expected tables and lists at most {DEPTH} deep, got deeper ones")


def _check_plain(value: Any, where: str, finite: bool) -> None:
    if isinstance(value, str):
        _check_text(value, where)
    elif isinstance(value, int) and not -INTEGER <= value < INTEGER:
        raise InputError(f"{where}: expected a whole number of 64 bits, got {_digits(value)}")
    elif finite and isinstance(value, float) and not abs(value) <= SIZE:
        want = f"a number of at most {SIZE:g}" if math.isfinite(value) else "a finite number"
        raise InputError(f"{where}: expected {want}, got {value}")


def _check_text(text: str, where: str) -> None:
    if not text.isprintable() and not all(c.isprintable() or c in "\n\t\r" for c in text):
        raise InputError(f"{where}: expected text without control characters, got {shown(text)}")


def _digits(value: int) -> str:
    return str(value) if abs(value) < 10**30 else f"one of {value.bit_length():,} bits"
