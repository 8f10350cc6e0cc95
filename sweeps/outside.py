"""Estimators as a sweep's workers find them, by what was asked for, and what tells one version of them from another."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

from imubench.errors import InputError
from imubench.estimators import Estimator
from imubench.inputs.files import real
from imubench.plugin_versions import estimator_version, package_version
from imubench.plugins import Outside, find_estimator

PEERS = ("qmt", "vqf")  # packages that estimators of our own call where they are installed


def absolute(name: str) -> str:
    """Return an estimator's text that means the same in any folder: FILE.py:FUNCTION gets an absolute path."""
    module, colon, function = name.rpartition(":")
    return f"{real(module)}:{function}" if colon and module.endswith(".py") else name


def fingerprints(places: Mapping[str, str]) -> dict[str, str]:
    """Return what tells each estimator from an older one of its name, of `estimator_version`.

    Args:
        places: what was asked for -> the same from any folder, of `absolute`.
    """
    return {name: estimator_version(find_estimator(place)) for name, place in places.items()}


def peers() -> dict[str, str]:
    """Return the versions of the packages that estimators of our own may call."""
    return {name: told for name in PEERS if (told := package_version(name))}


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
    if estimator_version(found) != fingerprint:
        raise InputError(
            f"{name}: expected the estimator that the sweep began with, got another one: its file, or one beside it, "
            "has changed"
        )
    if isinstance(found.estimate, Outside):
        return replace(found, name=name, estimate=replace(found.estimate, name=name))
    return found


def as_table(names: Sequence[str], prints: Mapping[str, str]) -> list[dict[str, str]]:
    """Return estimators and what tells them apart, as the result's file lists them."""
    return [{"estimator": name, "version": prints[name]} for name in names]
