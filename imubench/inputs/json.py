"""JSON, bounded and with one-line errors."""

import json
from pathlib import Path
from typing import Any

from imubench.errors import InputError, shown
from imubench.inputs.files import decode, read_bytes
from imubench.inputs.limits import DEPTH, TEXT_BYTES
from imubench.inputs.tree import checked


def parse_json(content: bytes, where: str) -> Any:
    """Return the value in the bytes of a JSON file.

    Args:
        content: the file.
        where: its name, for messages.

    Raises:
        InputError: no UTF-8, no JSON, a number that is not finite, or beyond the limits (see `tree.checked`).
    """
    text = decode(content, where)
    try:
        value = json.loads(text, parse_constant=_not_finite)
    except RecursionError:
        raise InputError(f"{where}: expected objects and lists at most {DEPTH} deep, got deeper ones") from None
    except ValueError as error:  # also a number of more digits than Python converts
        raise InputError(f"{where}: expected JSON, got: {error}") from None
    return checked(value, where)


def load_json(path: Path, most: int = TEXT_BYTES) -> Any:
    """Return the value of a JSON file of at most `most` bytes; `InputError` as `parse_json` and `files.read_bytes`."""
    return parse_json(read_bytes(path, most), str(path))


def load_table(path: Path, most: int = TEXT_BYTES) -> dict[str, Any]:
    """Return the object of a JSON file; `InputError` where it holds something else, and as `load_json`."""
    value = load_json(path, most)
    if not isinstance(value, dict):
        raise InputError(f"{path}: expected a JSON object, got {shown(value)}")
    return value


def _not_finite(text: str) -> float:
    raise ValueError(f"the number {text}, which is not finite")
