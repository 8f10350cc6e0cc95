"""What is known of a case apart from any diagnosis: `facts.toml`, checked."""

from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Any

from imubench.diagnosis.result import PLACES
from imubench.effects import EFFECTS
from imubench.errors import InputError, shown, unknown
from imubench.inputs.toml import load_toml

FILE = Path(__file__).parent / "facts.toml"
KEYS = {"cases", "known", "source", "complete", "may", "there"}
PART_KEYS = {"what", "names", "at", "above_hz"}

Name = tuple[str, str]
"""An effect and its place."""


@dataclass(frozen=True)
class Disturbance:
    """Something that is there: what names it, and where a finding without a name has located it."""

    what: str
    names: tuple[Name, ...]
    at: str
    above_hz: float  # Hz, where its band begins


@dataclass(frozen=True)
class Fact:
    """What is known of the cases of a pattern."""

    cases: str
    known: str
    source: str
    complete: bool  # whether everything that matters is listed
    may: tuple[Name, ...]
    there: tuple[Disturbance, ...]


@cache
def facts(file: Path = FILE) -> tuple[Fact, ...]:
    """Return the facts in the order of the file; `InputError` for a missing key, an unknown effect or place."""
    return tuple(_fact(entry, f"{file}, fact {i + 1}") for i, entry in enumerate(load_toml(file)["fact"]))


def fact_of(case: str, known: tuple[Fact, ...] | None = None) -> Fact:
    """Return the first fact whose pattern fits a case's name; `InputError` where there is none."""
    for fact in facts() if known is None else known:
        if fnmatchcase(case, fact.cases):
            return fact
    raise InputError(f"{FILE}: expected a fact for case {case}, got none")


def _fact(entry: Any, where: str) -> Fact:
    _keys(entry, KEYS, where)
    there = tuple(_disturbance(d, f"{where}, there") for d in entry["there"])
    may = tuple(_name(n, f"{where}, may") for n in entry["may"])
    return Fact(entry["cases"], entry["known"], entry["source"], bool(entry["complete"]), may, there)


def _disturbance(entry: Any, where: str) -> Disturbance:
    _keys(entry, PART_KEYS, where)
    names = tuple(_name(n, where) for n in entry["names"])
    return Disturbance(entry["what"], names, entry["at"], float(entry["above_hz"]))


def _keys(entry: Any, keys: set[str], where: str) -> None:
    if not isinstance(entry, dict) or entry.keys() != keys:
        got = ", ".join(sorted(entry)) if isinstance(entry, dict) else shown(entry)
        raise InputError(f"{where}: expected the keys {', '.join(sorted(keys))}, got {got}")


def _name(text: str, where: str) -> Name:
    effect, sign, at = text.partition(" at ")
    if not sign or not PLACES.fullmatch(at):
        raise InputError(f"{where}: expected 'effect at place', got '{text}'")
    if effect not in EFFECTS:
        raise unknown(f"{where}: effect", effect, EFFECTS)
    return effect, at
