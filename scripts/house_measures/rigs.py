"""Where code goes by the name of a rig, or of one of its segments and IMUs."""

import ast
import re
from collections.abc import Collection, Iterator
from pathlib import Path

from .rooms import House
from .sources import sources

RIGS_LIVE = ("models", "scenarios", "tests", "proof/rigs.py")  # the last: of the generator that shares no code with us
NO_RIG = ("base", "motion", "kind")  # what may be "free", too
LISTS = ("RIGS", "RIG_FILES", "SHAPES")  # in which a name is looked up, to see whether it is one
PARTS = re.compile(r"(segment|imu)[12]")


def rig_branches(root: Path, rigs: Collection[str]) -> list[str]:
    """Return where anything in the checkout goes by a rig's name, but where the rigs live.

    Counted are a comparison with a name, a table with a name as key, a collection of names, and a comparison of
    what is called `rig` or `family` with a constant.
    """
    return [
        f"{path.relative_to(root)}:{node.lineno}"
        for path in sources(root)
        if not path.relative_to(root).as_posix().startswith(RIGS_LIVE)
        for node in _of_rigs(ast.parse(path.read_text(encoding="utf-8")), frozenset(rigs))
    ]


def parts_named(house: House) -> list[str]:
    """Return where a segment or an IMU is named in quotes, as if it were known how many there are."""
    return [
        f"{m.name}:{node.lineno}: {node.value}"
        for m in house.modules.values()
        for node in ast.walk(m.tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and PARTS.fullmatch(node.value)
    ]


def _of_rigs(tree: ast.Module, rigs: frozenset[str]) -> Iterator[ast.expr | ast.pattern]:
    """Yield the nodes that go by a rig's name."""

    def named(node: ast.expr | None) -> bool:
        if isinstance(node, (ast.Tuple, ast.List, ast.Set)):
            return bool(node.elts) and all(named(part) for part in node.elts)
        return isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in rigs

    compared: set[ast.AST] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            sides = (node.left, *node.comparators)
            compared.update(sides)
            called = {_last_word(side) for side in sides}
            by_name = any(named(side) for side in sides) and not called & set(NO_RIG)
            by_constant = bool(called & {"rig", "family"}) and any(w.isupper() and w not in LISTS for w in called)
            if by_name or by_constant:
                yield node
        elif isinstance(node, ast.Dict):
            keys = [key.elts[0] if isinstance(key, ast.Tuple) and key.elts else key for key in node.keys]
            compared.update(key for key in node.keys if key is not None)
            if keys and all(named(key) for key in keys):
                yield node
        elif isinstance(node, (ast.Tuple, ast.List, ast.Set)):
            if named(node) and node not in compared:
                yield node
        elif isinstance(node, ast.MatchValue) and named(node.value):
            yield node


def _last_word(node: ast.expr) -> str:
    """Return how an expression ends: `rig` of `self.recording.rig`."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""
