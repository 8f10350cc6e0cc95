"""Modules that are too long."""

from .rooms import House

MOST_LINES = 400


def too_long(house: House) -> list[str]:
    """Return the modules of more than `MOST_LINES` lines."""
    return [
        name for name, m in house.modules.items() if len(m.path.read_text(encoding="utf-8").splitlines()) > MOST_LINES
    ]
