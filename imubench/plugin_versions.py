"""Estimators as other processes find them, and what tells one version of them from another."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from importlib.util import find_spec
from pathlib import Path

from imubench.errors import InputError
from imubench.estimators import Estimator
from imubench.inputs.files import read_bytes, real
from imubench.plugins import Outside, find_estimator

OURS = "ours"
"""Of an estimator of our own: told by the hash of this project's code, which whoever asks adds."""


def estimator_version(estimator: Estimator) -> str:
    """Return what changes with an estimator from outside; that of ours is `OURS`.

    Of a file: its content as it was loaded, and every module beside it. Of a module or an entry point: every module
    beside the one that has the function, and the version of its package. What those import from elsewhere is not in it.
    """
    outside = estimator.estimate
    if not isinstance(outside, Outside):
        return OURS
    if outside.content is not None:
        return _hash(outside.content, Path(outside.target.rpartition(":")[0]))
    own = outside.load()
    return module_version(module_of(own.estimate if isinstance(own, Estimator) else own))


def module_version(module: str) -> str:
    """Return what changes with an installed module: the versions of its package, a hash of the modules beside it."""
    package = module.partition(".")[0]
    told = [f"{name} {package_version(name)}" for name in dict.fromkeys(packages_distributions().get(package, []))]
    file = _source(module)
    return ", ".join([*told, _hash(read_bytes(file), file) if file is not None else "no source"])


@lru_cache(64)
def package_version(package: str) -> str:
    """Return the version of an installed package; empty where there is none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def absolute(name: str, folder: Path | None = None) -> str:
    """Return an estimator's text that means the same in any folder: FILE.py:FUNCTION gets an absolute path.

    Args:
        name: as `find_estimator` takes it.
        folder: where a file's relative path begins; None: where we are.
    """
    module, colon, function = name.rpartition(":")
    return f"{real((folder or Path()) / module)}:{function}" if colon and module.endswith(".py") else name


def versions(places: Mapping[str, str]) -> dict[str, str]:
    """Return what tells each estimator from an older one of its name, of `estimator_version`.

    Args:
        places: what was asked for -> the same from any folder, of `absolute`.
    """
    return {name: estimator_version(find_estimator(place)) for name, place in places.items()}


@lru_cache(64)
def loaded(name: str, place: str, version_then: str) -> Estimator:
    """Return an estimator, loaded once a process.

    Args:
        name: as it was asked for, and as its answers and failures call it.
        place: the same from any folder, of `absolute`.
        version_then: of `estimator_version`.

    Raises:
        InputError: there is none, or it is another one than the caller had.
    """
    found = find_estimator(place)
    if estimator_version(found) != version_then:
        raise InputError(
            f"{name}: expected the estimator that this work began with, got another one: its file, or one beside it, "
            "has changed"
        )
    if isinstance(found.estimate, Outside):
        return replace(found, name=name, estimate=replace(found.estimate, name=name))
    return found


def _hash(content: bytes, file: Path) -> str:
    digest = sha256(content)
    for source in sorted(file.parent.glob("*.py")):
        if source != file:
            digest.update(source.name.encode() + read_bytes(source))
    return digest.hexdigest()


def module_of(function: Callable[..., object]) -> str:
    """Return the module that a function comes from; that of its class where it is an object that can be called."""
    return str(getattr(function, "__module__", None) or type(function).__module__)


def _source(module: str) -> Path | None:
    try:
        found = find_spec(module)
    except (ImportError, ValueError):
        return None
    file = None if found is None or found.origin is None else Path(found.origin)
    return file if file is not None and file.suffix == ".py" else None


__all__ = [
    "OURS",
    "absolute",
    "estimator_version",
    "loaded",
    "module_of",
    "module_version",
    "package_version",
    "versions",
]
