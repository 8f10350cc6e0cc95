"""Every module of a checkout."""

import os
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def sources(root: Path) -> Iterator[Path]:
    """Yield the checkout's modules, of every folder but hidden ones and those that a build makes."""
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(f for f in folders if not f.startswith(".") and f not in ("build", "dist"))
        yield from (Path(folder, name) for name in sorted(files) if name.endswith(".py"))
