"""TOML read with one-line errors."""

import tomllib
from pathlib import Path
from typing import Any

from imubench.errors import InputError


def parse_toml(content: bytes, where: str) -> dict[str, Any]:
    """Return the tables in the bytes of a TOML file; `InputError` says where it is none."""
    try:
        return tomllib.loads(content.decode())
    except UnicodeDecodeError as error:
        raise InputError(f"{where}: expected UTF-8 text, got byte 0x{content[error.start]:02x}") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{where}: expected TOML, got: {error}") from None


def load_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file; `InputError` says what is wrong with it."""
    try:
        return parse_toml(path.read_bytes(), str(path))
    except OSError as error:
        raise InputError(f"{path}: expected a readable TOML file, got: {error.strerror}") from None
