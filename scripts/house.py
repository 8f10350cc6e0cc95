"""Measure how the diagnosis is built, beside what is allowed: `python scripts/house.py`.

Rooms are the folders of `diagnosis/` and `correction/`, in the order of `ROOMS`: a module imports modules of its own
room and of rooms below it. The modules that lie in `diagnosis/` itself are two rooms, of which the lower has what all
others speak in. `tests/test_house.py` holds every number to its limit.
"""

import ast
import os
import re
import sys
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
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
MOST_LINES = 400


@dataclass(frozen=True)
class Limit:
    """What a measure may be at most today, and what it is to become."""

    now: int
    aim: int


LIMITS: Mapping[str, Limit] = {
    "modules in the largest room": Limit(15, 15),
    "upward imports": Limit(0, 0),
    "modules over 400 lines": Limit(0, 0),
    "longest import chain": Limit(14, 14),
    "numeric constants": Limit(90, 90),
    "numbers in the config": Limit(397, 150),
    "constants of one name with different values": Limit(0, 0),
    "effects named outside of effects/": Limit(0, 0),
    "laws of effects used outside of effects/": Limit(0, 0),
    "docstrings with a past run's figure": Limit(0, 0),
    "branches on a rig's name": Limit(0, 0),
    "segments and IMUs by their name": Limit(0, 0),
}
"""Lower a limit in the change that lowers its measure. Where `now` is the aim, it is no longer a matter of time."""

WORDS_FOR_PEOPLE = ("report",)  # rooms in which an effect has its name in words
PAST = re.compile(
    r"\b(was|were|had|did|came|took|gained|lost|left|gave|promised|explained|became|fell|rose|grew|cost|needed|named)\b"
)
FIGURE = re.compile(r"(?<![\w.^'])\d[\d,.]*(?![\w'])")
RIGS_LIVE = ("models", "scenarios", "tests", "proof/rigs.py")  # the last: of the generator that shares no code with us
NO_RIG = ("base", "motion", "kind")  # what may be "free", too
LISTS = ("RIGS", "RIG_FILES", "SHAPES")  # in which a name is looked up, to see whether it is one
PARTS = re.compile(r"(segment|imu)[12]")


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
    """The modules of a checkout's diagnosis and what can be counted in them."""

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

    @cached_property
    def imports(self) -> dict[str, set[str]]:
        """By module: the modules of the house that it imports, anywhere in it."""
        return {name: set(self._imported(m)) for name, m in self.modules.items()}

    def _imported(self, m: Module) -> Iterator[str]:
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
                found = own if own in self.modules else own.rpartition(".")[0]
                if found in self.modules and found != m.name and name.startswith("imubench."):
                    yield found

    def upward(self) -> list[str]:
        """Return the imports that run from a lower room to a higher one."""
        height = {room: i for i, room in enumerate(reversed(ROOMS))}
        return [
            f"{name} imports {other}"
            for name, others in self.imports.items()
            for other in sorted(others)
            if not self.modules[other].is_package or self.imports[other]  # a docstring alone hands nothing on
            if height[self.modules[other].room] > height[self.modules[name].room]
        ]

    def chain(self) -> list[str]:
        """Return the longest chain of imports, from its top.

        Raises:
            ValueError: for modules that import each other in a circle.
        """
        under_way: list[str] = []

        @cache
        def below(name: str) -> tuple[str, ...]:
            if name in under_way:
                raise ValueError(f"imports in a circle: {' -> '.join([*under_way[under_way.index(name) :], name])}")
            under_way.append(name)
            longest = max((below(other) for other in sorted(self.imports[name])), key=len, default=())
            under_way.pop()
            return (name, *longest)

        return list(max((below(name) for name in self.modules), key=len))

    def constants(self) -> dict[str, dict[str, list[str]]]:
        """Return the constants of modules, by name, by value as written: the modules that have it."""
        found: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
        for m in self.modules.values():
            for names, value in _assigned(m.tree):
                for name in names:
                    found[name][ast.unparse(value)].append(m.name)
        return found

    def numeric(self) -> list[str]:
        """Return the constants of modules in whose value a number is written."""
        return [
            f"{m.name}.{name}"
            for m in self.modules.values()
            for names, value in _assigned(m.tree)
            if any(isinstance(n, ast.Constant) and type(n.value) in (int, float) for n in ast.walk(value))
            for name in names
        ]

    def settings(self) -> list[str]:
        """Return the fields of the config's records: constants of modules that have a unit, a reason and a source."""
        return [
            f"{m.name}.{node.name}.{line.target.id}"
            for m in self.modules.values()
            if m.room == "config"
            for node in m.tree.body
            if isinstance(node, ast.ClassDef)
            for line in node.body
            if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name) and line.value is not None
        ]

    def ambiguous(self) -> list[str]:
        """Return the names of constants that have different values in different modules."""
        several = {name: values for name, values in self.constants().items() if len(values) > 1}
        return [f"{name}: {len(values)} values, in {', '.join(_all(values))}" for name, values in several.items()]

    def effects_named(self, effects: Mapping[str, object]) -> list[str]:
        """Return where an effect is named in quotes, with a place or without, but in rooms that speak to people."""
        return [
            f"{m.name}:{node.lineno}: {node.value}"
            for m in self.modules.values()
            if m.room not in WORDS_FOR_PEOPLE
            for node in ast.walk(m.tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
            if node.value.partition("@")[0] in effects
        ]

    def laws_used(self, laws: Collection[str]) -> list[str]:
        """Return where one particular law is used: its class or an object of it, imported from a file of `effects/`.

        Where it is asked for its class, made anew, or written into a signature; `laws` are the names of all of them.
        """
        found = []
        for m in self.modules.values():
            own = {
                alias.asname or alias.name: alias.name
                for node in ast.walk(m.tree)
                if isinstance(node, ast.ImportFrom) and str(node.module).startswith("imubench.effects.")
                for alias in node.names
                if alias.name in laws
            }
            uses = (n for n in ast.walk(m.tree) if isinstance(n, ast.Name) and n.id in own)
            found += [f"{m.name}:{n.lineno}: {own[n.id]}" for n in uses]
        return found

    def rig_branches(self, rigs: Collection[str]) -> list[str]:
        """Return where anything in the checkout goes by a rig's name, but where the rigs live.

        Counted are a comparison with a name, a table with a name as key, a collection of names, and a comparison of
        what is called `rig` or `family` with a constant.
        """
        return [
            f"{path.relative_to(self.root)}:{node.lineno}"
            for path in self._sources()
            for node in _of_rigs(ast.parse(path.read_text(encoding="utf-8")), frozenset(rigs))
        ]

    def _sources(self) -> Iterator[Path]:
        """Yield the checkout's modules, but those in which rigs live."""
        for folder, folders, files in os.walk(self.root):
            folders[:] = sorted(f for f in folders if not f.startswith(".") and f not in ("build", "dist"))
            for path in (Path(folder, name) for name in sorted(files) if name.endswith(".py")):
                if not path.relative_to(self.root).as_posix().startswith(RIGS_LIVE):
                    yield path

    def parts_named(self) -> list[str]:
        """Return where a segment or an IMU is named in quotes, as if it were known how many there are."""
        return [
            f"{m.name}:{node.lineno}: {node.value}"
            for m in self.modules.values()
            for node in ast.walk(m.tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and PARTS.fullmatch(node.value)
        ]

    def told(self) -> list[str]:
        """Return the docstrings with a figure of a past run: a sentence with a number and a verb in the past tense."""
        found = []
        for m in self.modules.values():
            for node in ast.walk(m.tree):
                if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
                    sentences = re.split(r"(?<=[.:;])\s", ast.get_docstring(node) or "")
                    if any(PAST.search(s) and FIGURE.search(s) for s in sentences):
                        found.append(f"{m.name}:{getattr(node, 'name', '')}")
        return found

    def long(self) -> list[str]:
        """Return the modules of more than `MOST_LINES` lines."""
        return [n for n, m in self.modules.items() if len(m.path.read_text(encoding="utf-8").splitlines()) > MOST_LINES]

    def measures(
        self, effects: Mapping[str, object], laws: Collection[str], rigs: Collection[str]
    ) -> dict[str, tuple[int, list[str]]]:
        """Return each measure's number and what it counts.

        Args:
            effects: by name.
            laws: as `laws_of_effects` names them.
            rigs: their names.
        """
        rooms = self.rooms()
        chain = self.chain()
        counted: dict[str, Callable[[], list[str]]] = {
            "upward imports": self.upward,
            "modules over 400 lines": self.long,
            "numeric constants": self.numeric,
            "numbers in the config": self.settings,
            "constants of one name with different values": self.ambiguous,
            "effects named outside of effects/": lambda: self.effects_named(effects),
            "laws of effects used outside of effects/": lambda: self.laws_used(laws),
            "docstrings with a past run's figure": self.told,
            "branches on a rig's name": lambda: self.rig_branches(rigs),
            "segments and IMUs by their name": self.parts_named,
        }
        out = {
            "modules in the largest room": (max(rooms.values()), [f"{room} {n}" for room, n in rooms.items()]),
            "longest import chain": (len(chain), chain),
        }
        out |= {name: (len(told), told) for name, told in ((name, count()) for name, count in counted.items())}
        return {name: out[name] for name in LIMITS}


def laws_of_effects() -> set[str]:
    """Return the names in the files of `effects/` of every class of an effect, and of every object of one."""
    import imubench.effects
    from imubench.effects.effect import Effect

    files = (f"{imubench.effects.__name__}.{p.stem}" for p in (ROOT / "effects").glob("[a-z]*.py"))
    return {
        name
        for file in files
        for name, x in vars(import_module(file)).items()
        if isinstance(x, Effect) or (isinstance(x, type) and issubclass(x, Effect) and x is not Effect)
    }


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


def main(words: list[str]) -> int:
    """Print the rooms and every measure; with a measure's name, what it counts too."""
    from imubench.effects import EFFECTS
    from imubench.models import RIG_FILES

    house = House()
    for room, count in house.rooms().items():
        print(f"{room:20}{count:4}")
    print(f"\n{'':48}{'now':>6}{'limit':>7}{'aim':>6}")
    over = 0
    for name, (count, found) in house.measures(EFFECTS, laws_of_effects(), RIG_FILES).items():
        limit = LIMITS[name]
        note = "  over its limit" if count > limit.now else "  lower its limit" if count < limit.now else ""
        over += count > limit.now
        print(f"{name:48}{count:6}{limit.now:7}{limit.aim:6}{note}")
        if any(word in name for word in words):
            print("\n".join(f"    {line}" for line in found))
    return int(over > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
