"""Baselines: the errors of an earlier check by run, in its claims.json or a copy of that."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from imubench.checks.claim import Claim
from imubench.checks.versions import SIMULATING, code_key
from imubench.dataset.ranges import is_number
from imubench.errors import InputError, shown
from imubench.inputs.json import load_json
from imubench.inputs.limits import JSON_BYTES


@dataclass(frozen=True)
class Baseline:
    """What an earlier check says about one claim."""

    errors: dict[int, float]  # rad or m by run, inf without an estimate
    same_simulation: bool  # whether its runs are of the same recordings, bit for bit


def runs_as_dict(claim: Claim, first: int, errors: Sequence[float]) -> dict[str, Any]:
    """Return the part of an entry of claims.json that makes it a baseline."""
    return {
        "figure": claim.figure,
        "scenario": claim.scenario.key,
        "simulation": code_key(SIMULATING),
        "first_run": first,
        "errors": [None if math.isinf(e) else e for e in errors],  # rad or m; null: no estimate
    }


def read_baselines(path: Path, claims: Sequence[Claim]) -> dict[str, Baseline]:
    """Return the baselines of some claims by name; a claim that is new has none.

    Raises:
        InputError: the file is no claims.json of a check, or has another figure or scenario under a claim's name.
    """
    entries = load_json(path, JSON_BYTES)
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(f"{path}: expected the claims.json of a check, got {shown(entries)}")
    found = {entry["name"]: entry for entry in entries if isinstance(entry.get("name"), str) and "errors" in entry}
    if not found:
        raise InputError(f"{path}: expected the claims.json of a check, with the errors of each run, got none")
    return {c.name: _baseline(found[c.name], c, f"{path}: {c.name}") for c in claims if c.name in found}


def _baseline(entry: Mapping[str, Any], claim: Claim, where: str) -> Baseline:
    for key, now in (("figure", claim.figure), ("scenario", claim.scenario.key)):
        if entry.get(key) != now:
            raise InputError(f"{where}: expected the {key} of the claim, {now}, got {shown(entry.get(key))}")
    first, errors = entry.get("first_run"), entry["errors"]
    if not isinstance(first, int) or isinstance(first, bool) or first < 0:
        raise InputError(f"{where}.first_run: expected a whole number from 0 on, got {shown(first)}")
    if not isinstance(errors, list) or not all(e is None or (is_number(e) and e >= 0) for e in errors):
        raise InputError(f"{where}.errors: expected numbers from 0 on, or null, got {shown(errors)}")
    by_run = {first + i: math.inf if e is None else float(e) for i, e in enumerate(errors)}
    return Baseline(by_run, entry.get("simulation") == code_key(SIMULATING))
