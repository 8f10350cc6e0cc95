"""Modules that are too long."""

from pathlib import Path

from .sources import sources

MOST_LINES = 400


def too_long(root: Path) -> list[str]:
    """Return the checkout's modules of more than `MOST_LINES` lines, by their path."""
    return [
        path.relative_to(root).as_posix()
        for path in sources(root)
        if len(path.read_text(encoding="utf-8").splitlines()) > MOST_LINES
    ]
