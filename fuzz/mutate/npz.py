"""NumPy archives: arrays of other kinds and shapes, headers that lie, members that are none."""

import zipfile
from io import BytesIO
from random import Random

import numpy as np

from fuzz.mutate import bytes as plain


def mutate(content: bytes, rng: Random) -> bytes:
    """Return an .npz file with changed members, headers or bytes."""
    if rng.random() < 0.4:
        return plain.mutate(content, rng)
    out = BytesIO()
    try:
        with zipfile.ZipFile(BytesIO(content)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
            for name in old.namelist():
                _write(new, name, old.read(name), rng)
            if rng.random() < 0.2:
                new.writestr(_member(rng.choice(("../x.npy", "/x.npy", "x", "x.npy", ""))), b"")
    except (zipfile.BadZipFile, ValueError, OSError, IndexError):
        return plain.mutate(content, rng)
    return out.getvalue()


def _write(new: zipfile.ZipFile, name: str, member: bytes, rng: Random) -> None:
    kind = rng.randrange(8)
    if kind == 0:
        return
    if kind == 1:
        member = _saved(np.array([{"a": 1}, None], dtype=object))
    elif kind == 2:
        array = rng.choice(
            (np.zeros(0), np.array(1.0), np.zeros((2, 2)), np.array(["x"]), np.array([np.nan]), np.zeros(3, "c8"))
        )
        member = _saved(array)
    elif kind == 3:
        member = member.replace(b"'shape': (", b"'shape': (" + rng.choice((b"1000000000000, ", b"-1, ", b"0, ")), 1)
    elif kind == 4:
        member = plain.mutate(member, rng)
    elif kind == 5:
        member = member[:10] + b"(" * 3_000 + member[10:]
    elif kind == 6:
        member = _header(rng.choice((200_000_000, 20_000_000, 2**62))) + bytes(1_000_000)
    new.writestr(_member(name), member)


def _member(name: str) -> zipfile.ZipInfo:
    """Return the head of a member, whose time of writing is always the same."""
    head = zipfile.ZipInfo(name)
    head.compress_type = zipfile.ZIP_DEFLATED
    return head


def _header(rows: int) -> bytes:
    out = BytesIO()
    np.lib.format.write_array_header_1_0(out, {"descr": "<f8", "fortran_order": False, "shape": (rows,)})
    return out.getvalue()


def _saved(array: np.ndarray) -> bytes:
    out = BytesIO()
    np.save(out, array, allow_pickle=True)
    return out.getvalue()
