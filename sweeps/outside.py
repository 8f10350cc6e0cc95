"""Estimators as a sweep's workers find them, by what was asked for, and what tells one version of them from another."""

import hashlib
import inspect
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path

from imubench.errors import InputError
from imubench.estimators import Estimator, find
from imubench.inputs.files import read_bytes, real

PEERS = ("qmt", "vqf")  # packages that estimators of our own call where they are installed


def found(name: str) -> Estimator:
    """Return the estimator that a text stands for; `InputError` where there is none."""
    return find(name)


def absolute(name: str) -> str:
    """Return an estimator's text that means the same in any folder: FILE.py:FUNCTION gets an absolute path."""
    module, colon, function = name.rpartition(":")
    return f"{real(module)}:{function}" if colon and module.endswith(".py") else name


def fingerprints(names: Sequence[str]) -> dict[str, str]:
    """Return what tells each estimator from an older one of its name: the hash of its file, its package's version.

    Estimators of our own are told by the hash of this project's code. What a stranger's file imports is not looked at.
    """
    return {name: _fingerprint(absolute(name)) for name in names}


def peers() -> dict[str, str]:
    """Return the versions of the packages that estimators of our own may call."""
    return {name: told for name in PEERS if (told := _version(name))}


@lru_cache(maxsize=64)
def loaded(name: str, fingerprint: str) -> Estimator:
    """Return an estimator, loaded once a process.

    Raises:
        InputError: there is none, or it is another one than the caller had.
    """
    if _fingerprint(name) != fingerprint:
        raise InputError(f"{name}: expected the estimator that the sweep began with, got another one of that name")
    return found(name)


def _fingerprint(name: str) -> str:
    module, colon, _ = name.rpartition(":")
    if colon and module.endswith(".py"):
        return hashlib.sha256(read_bytes(Path(module))).hexdigest()
    estimate = found(name).estimate
    load = getattr(estimate, "load", None)
    if load is None:
        return "ours"
    function = load()
    function = getattr(function, "estimate", function)
    package = str(getattr(function, "__module__", "")).partition(".")[0]
    told = [f"{d} {_version(d)}" for d in packages_distributions().get(package, [])]
    try:
        file = inspect.getsourcefile(function)
    except TypeError:  # compiled
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
