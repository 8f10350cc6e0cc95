"""TOML: the tables changed and written again, or the text itself."""

import re
import tomllib
from datetime import date, datetime, time
from math import isinf, isnan
from random import Random
from typing import Any

from fuzz.mutate import nasty, text, tree

RAW = (
    "9" * nasty.DIGITS, "-" + "9" * nasty.DIGITS, "0." + "9" * nasty.DIGITS, "1e400", "-1e400", "1e-400", "nan", "-nan",
    "0x" + "f" * nasty.DIGITS, "[" * nasty.DEEP + "]" * nasty.DEEP, "{a=" * nasty.DEEP + "1" + "}" * nasty.DEEP,
    "1979-05-27", "07:32:00", "1979-05-27T07:32:00Z", "'''a\nb'''", '"\\u0000"', '"\\u001b[31m"', "''", "-0",
)  # fmt: skip
BARE = re.compile(r"[A-Za-z0-9_-]+")


def mutate(content: bytes, rng: Random) -> bytes:
    """Return TOML with changed values, keys, tables or lines."""
    if rng.random() < 0.35:
        return text.mutate(content, rng)
    if rng.random() < 0.05:
        return content + rng.choice((_deep_keys(), b"\n[" + b"a." * nasty.DEEP + b"a]\n", b"\n[[imu]]\n" * 3_000))
    try:
        parsed = tomllib.loads(content.decode())
    except (ValueError, RecursionError):
        return text.mutate(content, rng)
    found = tree.changed(parsed, rng, RAW)
    return dumped(found if isinstance(found, dict) else {"x": found}).encode("utf-8", "surrogatepass")


def _deep_keys() -> bytes:
    return b"\n" + b".".join([b"a"] * nasty.DEEP) + b" = 1\n"


def dumped(table: dict[str, Any], head: str = "") -> str:
    """Return a table as TOML, each inner table under a head of its own."""
    lines, below = [], []
    for key, value in table.items():
        name = f"{head}.{_key(key)}" if head else _key(key)
        if isinstance(value, dict) and value:
            below.append(f"[{name}]\n" + dumped(value, name))
        elif isinstance(value, list) and value and all(isinstance(v, dict) for v in value):
            below += [f"[[{name}]]\n" + dumped(v, name) for v in value]
        else:
            lines.append(f"{_key(key)} = {_inline(value)}\n")
    return "".join(lines) + "\n".join(["", *below])


def _key(key: object) -> str:
    return str(key) if BARE.fullmatch(str(key)) else _quoted(str(key))


def _quoted(value: str) -> str:
    out = (c if c.isprintable() and c not in '"\\' else f"\\U{ord(c):08x}" for c in value)
    return '"' + "".join(out) + '"'


def _inline(value: Any) -> str:
    if isinstance(value, nasty.Raw):
        return value
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_inline(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and (isnan(value) or isinf(value)):
        return "nan" if isnan(value) else ("inf" if value > 0 else "-inf")
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, date | time | datetime):
        return value.isoformat()
    return _quoted("" if value is None else str(value))
