"""Constants of the diagnosis: those with a number, those in the config, and those of one name with several values."""

import ast
from collections import defaultdict
from collections.abc import Iterator, Mapping

from .rooms import House


def constants(house: House) -> dict[str, dict[str, list[str]]]:
    """Return the constants of modules, by name, by value as written: the modules that have it."""
    found: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for m in house.modules.values():
        for names, value in _assigned(m.tree):
            for name in names:
                found[name][ast.unparse(value)].append(m.name)
    return found


def numeric(house: House) -> list[str]:
    """Return the constants of modules in whose value a number is written."""
    return [
        f"{m.name}.{name}"
        for m in house.modules.values()
        for names, value in _assigned(m.tree)
        if any(isinstance(n, ast.Constant) and type(n.value) in (int, float) for n in ast.walk(value))
        for name in names
    ]


def settings(house: House) -> list[str]:
    """Return the fields of the config's records: constants of modules that have a unit, a reason and a source."""
    return [
        f"{m.name}.{node.name}.{line.target.id}"
        for m in house.modules.values()
        if m.room == "config"
        for node in m.tree.body
        if isinstance(node, ast.ClassDef)
        for line in node.body
        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name) and line.value is not None
    ]


def ambiguous(house: House) -> list[str]:
    """Return the names of constants that have different values in different modules."""
    several = {name: values for name, values in constants(house).items() if len(values) > 1}
    return [f"{name}: {len(values)} values, in {', '.join(_all(values))}" for name, values in several.items()]


def _assigned(tree: ast.Module) -> Iterator[tuple[list[str], ast.expr]]:
    """Yield the constants that a module assigns, names in capitals, with what is assigned."""
    for node in tree.body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            pairs = [pair for target in targets for pair in _pairs(target, node.value)]
            for name, value in pairs:
                if name.isupper():
                    yield [name], value


def _pairs(target: ast.expr, value: ast.expr) -> Iterator[tuple[str, ast.expr]]:
    """Yield each name of an assignment with its own part of the value."""
    if isinstance(target, ast.Name):
        yield target.id, value
    elif isinstance(target, ast.Tuple):
        parts = value.elts if isinstance(value, ast.Tuple) else [value] * len(target.elts)
        for one, part in zip(target.elts, parts, strict=True):
            yield from _pairs(one, part)


def _all(values: Mapping[str, list[str]]) -> list[str]:
    return [module for modules in values.values() for module in modules]
