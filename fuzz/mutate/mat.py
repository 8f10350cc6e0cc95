"""MATLAB files: variables of other kinds, written by scipy; then tags, sizes and compressed blocks damaged."""

import zlib
from io import BytesIO
from random import Random
from typing import Any

import numpy as np
from scipy.io import loadmat, savemat
from scipy.sparse import csc_matrix

from fuzz.mutate import bytes as plain
from fuzz.mutate import nasty

HEADER = 128  # bytes in front of the first element of a level 5 file


def mutate(content: bytes, rng: Random) -> bytes:
    """Return a .mat file with changed variables, tags, sizes or bytes."""
    kind = rng.random()
    if kind < 0.2:
        return plain.mutate(content, rng)
    if kind < 0.5:
        return _tags(content, rng)
    try:
        variables = {k: v for k, v in loadmat(BytesIO(content)).items() if not k.startswith("__")}
        for _ in range(1 + min(int(rng.expovariate(1.0)), 2)):
            _change(variables, rng)
        out = BytesIO()
        level = rng.choice(("5",) * 9 + ("4",))
        savemat(out, variables, format=level, do_compression=rng.random() < 0.5, long_field_names=True)
    except Exception:  # what scipy cannot write, it says in many ways
        return _tags(content, rng)
    found = untimed(out.getvalue()) if level == "5" else out.getvalue()
    return _tags(found, rng) if rng.random() < 0.15 else found


def untimed(content: bytes) -> bytes:
    """Return a level 5 file without the time at which it was written."""
    return b"MATLAB 5.0 MAT-file".ljust(116) + content[116:]


def _change(variables: dict[str, Any], rng: Random) -> None:
    name = rng.choice(list(variables) or ["dt"])
    kind = rng.randrange(8)
    if kind == 0:
        variables.pop(name, None)
    elif kind == 1:
        variables[rng.choice(("x", "Time_id", "Y_id", "a" * 40))] = variables.pop(name, 0.0)
    elif kind == 2:
        variables[name] = rng.choice(list(variables.values()) or [0.0])
    elif kind < 6 and isinstance(variables.get(name), np.ndarray) and variables[name].dtype == object:
        cell = variables[name].copy().ravel()
        if cell.size:
            cell[rng.randrange(cell.size)] = _value(rng, cell[rng.randrange(cell.size)])
        variables[name] = rng.choice((cell, cell[:1], cell[:0], cell.reshape(1, -1), np.concatenate([cell, cell])))
    else:
        variables[name] = _value(rng, variables.get(name))


def _value(rng: Random, old: Any) -> Any:
    shape = np.shape(old) or (3,)
    nested = np.empty(2, dtype=object)
    nested[:] = [np.ones(3), "x"]
    return rng.choice(
        (
            0.0, float("nan"), float("inf"), "text", "", nasty.TEXTS[2], np.zeros(0), np.zeros((0, 2)),
            np.ones((2, 2, 2)),
            np.zeros(shape if isinstance(shape, tuple) else 3, dtype=complex), np.array([1, 2, 3], dtype=np.int8),
            np.array([True, False]), {"a": 1.0, "b": [1, 2]}, {}, csc_matrix(np.eye(3)), nested, np.full(10, 1e308),
            np.arange(10.0)[:, None], -np.arange(10.0)[:, None], np.zeros((2, 10)), np.array(["a", "bc"]), old,
        )
    )  # fmt: skip


def _tags(content: bytes, rng: Random) -> bytes:
    """Return a level 5 file with one element's type, size or body changed, or an element that is none."""
    if len(content) < HEADER + 16:
        return plain.mutate(content, rng)
    out = bytearray(content)
    kind = rng.randrange(7)
    if kind == 0:
        out[124:128] = rng.choice(
            (b"\x00\x02IM", b"\x00\x01MI", b"\x01\x00MI", b"\x00\x02HD", b"\xff\xffIM", b"\0\0\0\0")
        )
        return bytes(out)
    starts = _elements(content)
    at = rng.choice(starts)
    if kind == 1:
        out[at : at + 4] = rng.choice((0, 1, 2, 5, 7, 9, 12, 13, 14, 15, 16, 17, 18, 255, 2**31)).to_bytes(4, "little")
    elif kind == 2:
        out[at + 4 : at + 8] = (rng.choice(plain.SIZES) % 2**32).to_bytes(4, "little")
    elif kind == 3:
        packed = zlib.compress(rng.choice((bytes(50_000_000), b"", b"x" * 100, content[HEADER:])), 9)
        out[at:at] = (15).to_bytes(4, "little") + len(packed).to_bytes(4, "little") + packed
    elif kind == 4:
        dims = rng.choice((0x7FFFFFFF, 0xFFFFFFFF, 50_000, 1_000_000, 0))
        inner = at + 8 + rng.choice((24, 28))
        out[inner : inner + 4] = dims.to_bytes(4, "little")
    else:
        return content[: at + 8] + plain.mutate(content[at + 8 :], rng)
    return bytes(out)


def zeros(content: bytes, size: int) -> bytes:
    """Return a level 5 file with an element in front that is so many bytes of zeros, compressed."""
    packer = zlib.compressobj(9)
    block = bytes(10_000_000)
    packed = b"".join(packer.compress(block) for _ in range(size // len(block))) + packer.flush()
    return content[:HEADER] + (15).to_bytes(4, "little") + len(packed).to_bytes(4, "little") + packed + content[HEADER:]


def _elements(content: bytes) -> list[int]:
    """Return where the elements at the top of a level 5 file begin."""
    found, at = [], HEADER
    while at + 8 <= len(content):
        found.append(at)
        at += 8 + int.from_bytes(content[at + 4 : at + 8], "little")
    return found
