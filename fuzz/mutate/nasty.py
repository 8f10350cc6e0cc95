"""Values that readers have stumbled over: numbers, texts, names, paths, and tokens that no writer would write."""

from random import Random
from typing import Any

OUTSIDE = "/tmp/imubench-fuzz/w00/outside"
"""Files that no reader may open, write or remove. A worker writes its own two digits into every input."""

DEEP = 3_000  # levels of nesting, beyond Python's recursion limit of 1,000
DIGITS = 5_000  # of a number, beyond the 4,300 that Python turns into an int
CELL = 140_000  # characters, beyond the 131,072 that Python's csv module takes

ESCAPES = ("\x1b[31mred\x1b[0m", "a\x07b", "a\x1b]0;title\x07", "a\rb", "a\nb", "\x00", "a\x00b", "\x7f", "\x9b1m")
PATHS = (
    "../../x", "..", ".", "/", "../outside/kept.csv", "../outside/kept.xml", f"{OUTSIDE}/kept.csv",
    f"{OUTSIDE}/kept.xml", f"{OUTSIDE}/kept.parquet", f"{OUTSIDE}/kept.toml", f"{OUTSIDE}/kept.hdf5", "/dev/zero",
    "/dev/stdin", "C:\\x", "..\\..\\x", "\\\\server\\share", "~", "sub/../../outside/kept.csv", "file:///etc/hostname",
    "memory://x", "recording.toml", "imu1.csv", "x/" * 60 + "x",
)  # fmt: skip
TEXTS = (
    "", " ", "\t", "x" * 300, "x" * 5_000, "é", "日本語", "\u202eabc", "\ufeff", "\u2028", "\U0001f980", "[/y]",
    "x[/y]",
    "[bold]", "[link=file:///]x", "%s%n", "{0}", "'", '"', "\\", "-", "--out", "nan", "inf", "None", "true", "0x10",
    "1_000", "1e400", "imu3", "imu", "hinge", "pendulum", "free", "world", "joint", "segment1", "unknown",
)  # fmt: skip
NUMBERS: tuple[Any, ...] = (
    0, 1, -1, 2, 3, 7, 0.5, -0.0, 1e-12, 1e-300, 5e-324, 1e6, 1e12, 1e300, 1.7e308, 2**31 - 1, 2**31, 2**53 + 1, 2**63,
    2**64, 10**30, 10**400, -(2**63), float("nan"), float("inf"), float("-inf"), True, False,
)  # fmt: skip


class Raw(str):
    """A token that is written as it stands, whatever the format says."""


def text(rng: Random) -> str:
    """Return a text that a name, a path or a summary may be."""
    kind = rng.random()
    if kind < 0.3:
        return rng.choice(PATHS)
    if kind < 0.5:
        return rng.choice(ESCAPES)
    if kind < 0.52:
        return "x" * 200_000
    return rng.choice(TEXTS)


def number(rng: Random) -> Any:
    """Return a number of any size and kind."""
    return rng.choice(NUMBERS) if rng.random() < 0.8 else rng.gauss(0, 1) * 10.0 ** rng.randint(-20, 20)


def container(rng: Random) -> Any:
    """Return a list or a table where none belongs."""
    return rng.choice(
        (
            [], {}, [[]], [{}], ["imu1"], ["a", 1], [1, 2], [1, 2, 3], [1.0, 0.0, 0.0, 0.0], [[1, 2], [3]],
            {"a": 1}, {"value": 1}, {"low": 1, "high": 2}, {"": ""}, [None], [0.0] * 1_000, ["x"] * 1_000,
        )
    )  # fmt: skip
