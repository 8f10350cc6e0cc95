"""Estimators as a sweep's workers find them, by what was asked for, and what tells one version of them from another."""

import hashlib
import inspect
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path

from imubench.errors import InputError
from imubench.estimators import Estimator
from imubench.inputs.files import read_bytes, real
from imubench.plugins import Outside, find_estimator

PEERS = ("qmt", "vqf")  # packages that estimators of our own call where they are installed


def absolute(name: str) -> str:
    """Return an estimator's text that means the same in any folder: FILE.py:FUNCTION gets an absolute path."""
    module, colon, function = name.rpartition(":")
    return f"{real(module)}:{function}" if colon and module.endswith(".py") else name


def fingerprints(places: Mapping[str, str]) -> dict[str, str]:
    """Return what tells each estimator from an older one of its name: the hash of its file, its package's version.

    Estimators of our own are told by the hash of this project's code. What a stranger's file imports is not looked at.

    Args:
        places: what was asked for -> the same from any folder, of `absolute`.
    """
    return {name: _fingerprint(find_estimator(place)) for name, place in places.items()}


def peers() -> dict[str, str]:
    """Return the versions of the packages that estimators of our own may call."""
    return {name: told for name in PEERS if (told := _version(name))}


@lru_cache(maxsize=64)
def loaded(name: str, place: str, fingerprint: str) -> Estimator:
    """Return an estimator, loaded once a process.

    Args:
        name: as it was asked for, and as its answers and failures call it.
        place: the same from any folder, of `absolute`.
        fingerprint: of `fingerprints`.

    Raises:
        InputError: there is none, or it is another one than the caller had.
    """
    found = find_estimator(place)
    if _fingerprint(found) != fingerprint:
        raise InputError(f"{name}: expected the estimator that the sweep began with, got another one of that name")
    if isinstance(found.estimate, Outside):
        return replace(found, name=name, estimate=replace(found.estimate, name=name))
    return found


def _fingerprint(found: Estimator) -> str:
    outside = found.estimate
    if not isinstance(outside, Outside):
        return "ours"
    if outside.content is not None:
        return hashlib.sha256(outside.content).hexdigest()
    own = outside.load()
    function = own.estimate if isinstance(own, Estimator) else own
    package = str(getattr(function, "__module__", "")).partition(".")[0]
    told = [f"{d} {_version(d)}" for d in packages_distributions().get(package, [])]
    try:
        file = inspect.getsourcefile(function)
    except TypeError:  # compiled, or an object that can be called
        file = None
    return ", ".join([*told, hashlib.sha256(read_bytes(Path(file))).hexdigest() if file else "no source"])


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def as_table(names: Sequence[str], prints: Mapping[str, str]) -> list[dict[str, str]]:
    """Return estimators and what tells them apart, as the result's file lists them."""
    return [{"estimator": name, "version": prints[name]} for name in names]
