"""A truth sealed: the hash that is published first, and the check afterwards that nothing was changed.

    commitment = SHA-256(truth as bytes + salt)

The bytes are the JSON with sorted keys and no spaces. The salt is HMAC-SHA256(seed, name of the case): no file holds
it before the end, and a run that was killed finds the same one again from its seed.
"""

import hashlib
import hmac
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from imubench.errors import InputError
from imubench.inputs.json import load_table
from imubench.inputs.limits import JSON_BYTES

Truth = dict[str, Any]


def salt_of(seed: int, name: str) -> str:
    """Return the salt of a case as 64 hexadecimal digits."""
    return hmac.new(str(seed).encode(), f"salt of {name}".encode(), hashlib.sha256).hexdigest()


def truth_bytes(truth: Truth) -> bytes:
    """Return the bytes that are sealed; a truth with a number that is not finite is refused with ValueError."""
    return json.dumps(truth, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def commitment(truth: Truth, salt: str) -> str:
    """Return the hash that binds a truth without telling it."""
    return hashlib.sha256(truth_bytes(truth) + salt.encode()).hexdigest()


def folder_hash(folder: Path) -> str:
    """Return the hash of every file name and byte below a folder."""
    digest = hashlib.sha256()
    for file in sorted(p for p in folder.rglob("*") if p.is_file()):
        content = file.read_bytes()
        digest.update(f"{file.relative_to(folder).as_posix()}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()


def check(commitments: Mapping[str, Mapping[str, str]], truths: Mapping[str, Truth], salts: Mapping[str, str]) -> None:
    """Raise `InputError` unless every committed truth is there and is the one that was sealed."""
    if commitments.keys() != truths.keys():
        odd = sorted(commitments.keys() ^ truths.keys())
        raise InputError(f"seal: expected a truth for every commitment and no other, got a difference in {odd[:5]}")
    for name, truth in truths.items():
        if commitment(truth, salts[name]) != commitments[name]["truth"]:
            raise InputError(f"seal of case {name}: expected the truth that was sealed, got one with another hash")


def check_proof(folder: Path) -> int:
    """Check the seals of a finished proof on disk against its opened truths and return how many there are."""
    public, told = (load_table(folder / name, JSON_BYTES) for name in ("commitments.json", "truths.json"))
    sealed = public.get("cases")
    if not isinstance(sealed, dict) or not all(_is_case(c, {"truth": str}) for c in sealed.values()):
        raise InputError(f"{folder / 'commitments.json'}: expected cases, each with the hash of its truth")
    if not all(_is_case(c, {"truth": dict, "salt": str}) for c in told.values()):
        raise InputError(f"{folder / 'truths.json'}: expected cases, each with its truth and salt")
    truths = {name: case["truth"] for name, case in told.items()}
    salts = {name: case["salt"] for name, case in told.items()}
    check(sealed, truths, salts)
    return len(sealed)


def _is_case(case: object, keys: Mapping[str, type]) -> bool:
    return isinstance(case, dict) and all(isinstance(case.get(key), kind) for key, kind in keys.items())
