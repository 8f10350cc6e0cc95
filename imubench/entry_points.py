"""What installed packages offer by entry points; a broken one breaks no other, and says so when it is asked for."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, reduce
from importlib import import_module
from importlib.metadata import Distribution, EntryPoint, distributions, entry_points
from pathlib import Path
from sysconfig import get_path
from traceback import walk_tb
from types import ModuleType

from imubench.errors import InputError, first_line, unknown

ESTIMATORS, CONVERTERS, SCENARIOS = "imubench.estimators", "imubench.converters", "imubench.scenarios"
EFFECTS, RIGS = "imubench.effects", "imubench.rigs"
"""The groups of entry points that are looked at."""
OURS = str(Path(__file__).parent)
PACKAGES = "site-packages", "dist-packages"
"""Folders of what is installed; a user's own line says more than one in there."""


def offered(group: str) -> dict[str, tuple[EntryPoint, ...]]:
    """Return the entry points of a group by name, without importing a package; two may have the same name."""
    return _offered(group, tuple(sys.path))


def target(point: EntryPoint) -> str:
    """Return MODULE:NAME of an entry point; one that names a module alone has no name in it."""
    return point.value.partition("[")[0].strip() if ":" in point.value else f"{point.value}:"


def origin(points: tuple[EntryPoint, ...]) -> str:
    """Return where entry points come from, for people: `from package theirs 1.2`."""
    return f"from {' and '.join(map(_package, points))}"


def the_one(name: str, points: tuple[EntryPoint, ...], kind: str) -> EntryPoint:
    """Return the entry point of a name; `InputError` where two packages offer it."""
    if len(points) > 1:
        raise InputError(f"{kind} '{name}': expected one package to offer it, got {', '.join(map(_package, points))}")
    return points[0]


def from_package(group: str, name: str, kind: str, wanted: type) -> object | None:
    """Return what a package offers under a name, imported; None where none does.

    Raises:
        InputError: two packages offer it, it cannot be imported, or it is no `wanted`.
    """
    points = offered(group).get(name)
    if points is None:
        return None
    where = target(the_one(name, points, kind))
    module, _, path = where.rpartition(":")
    try:
        found = attribute(imported(module), path, module, kind)
    except InputError as error:
        raise InputError(f"{kind} '{name}': {error}") from None
    if not isinstance(found, wanted):
        raise InputError(f"{kind} '{name}': expected a {wanted.__name__} in {where}, got {type(found).__name__}")
    return found


def imported(name: str) -> ModuleType:
    """Return a module that Python finds; `InputError` in one line where it finds none, or that cannot be imported."""
    try:
        return import_module(name)
    except (Exception, SystemExit) as error:  # TypeError, where the text is no name of a module
        if isinstance(error, ModuleNotFoundError) and error.name and f"{name}.".startswith(f"{error.name}."):
            raise InputError(f"{name}: expected an installed module, got none called '{error.name}'") from None
        raise InputError(f"{name}: expected a module that can be imported, got {said(error)}") from None


def attribute(module: ModuleType, path: str, where: str, kind: str) -> object:
    """Return what a dotted path leads to in a module; `InputError` names what the module defines."""
    try:
        return reduce(getattr, path.split("."), module)
    except AttributeError:
        own = [name for name, x in vars(module).items() if _defined_in(module, x)]
        raise unknown(f"{kind} in {where}", path, own or ("none",)) from None


def _defined_in(module: ModuleType, x: object) -> bool:
    """Return whether something may be what was meant: a function or class of the module, or an object of ours in it."""
    own = callable(x) and getattr(x, "__module__", None) == module.__name__
    return own or (not isinstance(x, type) and type(x).__module__.startswith("imubench."))


@contextmanager
def blamed(what: str) -> Iterator[None]:
    """Make bad input of an error in a stranger's code, which is no defect of ours; `what` says whose."""
    try:
        yield
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise InputError(f"{what}: expected it to work, got {said(error)}") from error


def said(error: BaseException) -> str:
    """Return a stranger's error in a line: its kind, what it says, and where in the stranger's code it came up."""
    places = [
        (frame.f_code.co_filename, line)
        for frame, line in walk_tb(error.__traceback__)
        if not frame.f_code.co_filename.startswith((OURS, "<"))
    ]
    written = [place for place in places if not _installed(place[0])]
    place = written[-1] if written else places[0] if places else None
    try:
        text = first_line(error)
    except Exception:  # its text is an error too
        text = ""
    kind = type(error).__name__
    where = "" if place is None else f" ({Path(place[0]).name}, line {place[1]})"
    return (f"{kind}: {text}" if text not in ("", kind) else kind) + where


def _installed(file: str) -> bool:
    return file.startswith(get_path("stdlib")) or any(folder in Path(file).parts for folder in PACKAGES)


@cache
def _offered(group: str, path: tuple[str, ...]) -> dict[str, tuple[EntryPoint, ...]]:
    found: dict[str, tuple[EntryPoint, ...]] = {}
    for one in sorted(_entry_points(group), key=_package):  # folders have no order of their own
        if one.value not in [other.value for other in found.get(one.name, ())]:
            found[one.name] = (*found.get(one.name, ()), one)
    return found


def _entry_points(group: str) -> list[EntryPoint]:
    try:
        return list(entry_points(group=group))
    except Exception:  # the list of some package cannot be read: those of the others can
        return [one for package in distributions() for one in _readable(package) if one.group == group]


def _readable(package: Distribution) -> list[EntryPoint]:
    try:
        return list(package.entry_points)
    except Exception:
        return []


def _package(point: EntryPoint) -> str:
    return f"package {point.dist.name} {point.dist.version}" if point.dist is not None else point.value
