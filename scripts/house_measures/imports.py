"""Imports of the diagnosis: those that run upward, and the longest chain."""

import ast
from collections.abc import Iterator
from functools import cache

from .rooms import ROOMS, House, Module


@cache
def imports(house: House) -> dict[str, set[str]]:
    """Return by module: the modules of the house that it imports, anywhere in it."""
    return {name: set(_imported(house, m)) for name, m in house.modules.items()}


def _imported(house: House, m: Module) -> Iterator[str]:
    package = m.name if m.is_package else m.name.rpartition(".")[0]
    for node in ast.walk(m.tree):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join(["imubench", *above, *([node.module] if node.module else [])])
            base = base if node.level else str(node.module)
            names = [f"{base}.{alias.name}" for alias in node.names]
        for name in names:
            own = name.removeprefix("imubench.")
            found = own if own in house.modules else own.rpartition(".")[0]
            if found in house.modules and found != m.name and name.startswith("imubench."):
                yield found


def upward(house: House) -> list[str]:
    """Return the imports that run from a lower room to a higher one."""
    height = {room: i for i, room in enumerate(reversed(ROOMS))}
    imported, modules = imports(house), house.modules
    return [
        f"{name} imports {other}"
        for name, others in imported.items()
        for other in sorted(others)
        if not modules[other].is_package or imported[other]  # a docstring alone hands nothing on
        if height[modules[other].room] > height[modules[name].room]
    ]


def chain(house: House) -> list[str]:
    """Return the longest chain of imports, from its top.

    Raises:
        ValueError: for modules that import each other in a circle.
    """
    imported = imports(house)
    under_way: list[str] = []

    @cache
    def below(name: str) -> tuple[str, ...]:
        if name in under_way:
            raise ValueError(f"imports in a circle: {' -> '.join([*under_way[under_way.index(name) :], name])}")
        under_way.append(name)
        longest = max((below(other) for other in sorted(imported[name])), key=len, default=())
        under_way.pop()
        return (name, *longest)

    return list(max((below(name) for name in house.modules), key=len))
