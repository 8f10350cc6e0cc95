"""TOML, bounded and with one-line errors."""

import tomllib
from pathlib import Path
from typing import Any

from imubench.errors import InputError
from imubench.inputs.files import decode, read_bytes
from imubench.inputs.limits import DEPTH
from imubench.inputs.tree import checked


def parse_toml(content: bytes, where: str, finite: bool = True) -> dict[str, Any]:
    """Return the tables in the bytes of a TOML file.

    Args:
        content: the file.
        where: its name, for messages.
        finite: whether a number that is not finite is refused.

    Raises:
        InputError: no UTF-8, no TOML, or beyond the limits (see `tree.checked`): depth, numbers, control characters.
    """
    text = decode(content, where).removeprefix("\ufeff")
    try:
        table = tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{where}: expected tables and lists at most {DEPTH} deep, got deeper ones") from None
    except ValueError as error:  # also a number of more digits than Python converts
        raise InputError(f"{where}: expected TOML, got: {error}") from None
    found: dict[str, Any] = checked(table, where, finite)
    return found


def load_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file; `InputError` as `parse_toml` and `files.read_bytes`."""
    return parse_toml(read_bytes(path), str(path))
