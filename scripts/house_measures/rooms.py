"""The modules of the diagnosis and the rooms that they lie in.

Rooms are the folders of `diagnosis/` and `correction/`, in the order of `ROOMS`: a module imports modules of its own
room and of rooms below it. The modules that lie in `diagnosis/` itself are two rooms, of which the lower has what all
others speak in.
"""

import ast
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from .sources import ROOT

TOPS = ("diagnosis", "correction")
ROOMS = (
    "pipeline",
    "report",
    "simulation",
    "correction",
    "nonsense",
    "verdict",
    "experiments",
    "search",
    "search.moves",
    "candidates",
    "residual_checks",
    "discrepancy",
    "criteria",
    "sensor_errors",
    "noise",
    "solve",
    "problem",
    "samples",
    "result",
    "config",
)
"""From top to bottom."""
UPPERMOST = ("pipeline", "on_disk")  # of the modules in diagnosis/ itself; the others are the room `result`


@dataclass(frozen=True)
class Module:
    """One module of the diagnosis."""

    name: str  # as "diagnosis.solve.bordered"
    path: Path

    @cached_property
    def tree(self) -> ast.Module:
        """Its syntax."""
        return ast.parse(self.path.read_text(encoding="utf-8"))

    @property
    def room(self) -> str:
        """The room that it lies in."""
        folder = self.path.parent
        top = next(p for p in (folder, *folder.parents) if p.name in TOPS)
        inside = folder.relative_to(top).parts
        if top.name == "correction":
            return ".".join(("correction", *inside))
        if inside:
            return ".".join(inside)
        return "pipeline" if self.path.stem in UPPERMOST else "result"

    @property
    def is_package(self) -> bool:
        """Whether it only says what its folder holds."""
        return self.path.name == "__init__.py"


class House:
    """The modules of a checkout's diagnosis, by name."""

    def __init__(self, root: Path = ROOT) -> None:
        """Find the modules below a checkout."""
        self.root = root
        self.modules: dict[str, Module] = {}
        for path in sorted(p for top in TOPS for p in (root / top).rglob("*.py")):
            name = ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__")
            self.modules[name] = Module(name, path)

    def rooms(self) -> dict[str, int]:
        """Return how many modules each room has, from top to bottom.

        Raises:
            ValueError: for a folder that has no place in `ROOMS`.
        """
        found = dict.fromkeys(ROOMS, 0)
        for m in self.modules.values():
            if m.room not in found:
                raise ValueError(f"unknown room '{m.room}'; known: {', '.join(ROOMS)}")
            found[m.room] += not m.is_package
        return found
