"""JSON: the tree changed and written again, or the text itself."""

import json
from random import Random
from typing import Any

from fuzz.mutate import nasty, text, tree

RAW = (
    "9" * nasty.DIGITS, "-" + "9" * nasty.DIGITS, "0." + "9" * nasty.DIGITS, "1e400", "-1e400", "NaN", "Infinity",
    "-Infinity", "null", "[" * nasty.DEEP + "]" * nasty.DEEP, '{"a":' * nasty.DEEP + "1" + "}" * nasty.DEEP,
    "[" * 200_000, '"\\ud800"', '"\\u0000"', '"\\u001b[31m"', "01", ".5", "'a'", "1,",
)  # fmt: skip


def mutate(content: bytes, rng: Random) -> bytes:
    """Return JSON with changed values, keys or text."""
    if rng.random() < 0.3:
        return text.mutate(content, rng)
    if rng.random() < 0.03:
        return rng.choice((b"", b"null", b"[]", b"{}", b"0", b'""', b"[[]]", b"true", b"[" * 200_000))
    try:
        parsed = json.loads(content)
    except (ValueError, RecursionError):
        return text.mutate(content, rng)
    return dumped(tree.changed(parsed, rng, RAW), rng.random() < 0.5).encode("utf-8", "surrogatepass")


def dumped(value: Any, ascii_only: bool = True) -> str:
    """Return a tree as JSON."""
    if isinstance(value, nasty.Raw):
        return value
    if isinstance(value, dict):
        inner = (f"{json.dumps(str(k), ensure_ascii=ascii_only)}: {dumped(v, ascii_only)}" for k, v in value.items())
        return "{" + ", ".join(inner) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(dumped(v, ascii_only) for v in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=ascii_only)
    return json.dumps(value)
