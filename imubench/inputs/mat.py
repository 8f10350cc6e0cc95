"""MATLAB files of version 5, whose compressed parts are measured before they are unpacked."""

import struct
import zlib
from collections.abc import Iterator, Sequence
from math import prod
from pathlib import Path
from typing import Any, BinaryIO

from imubench.errors import InputError, first_line
from imubench.inputs.files import opened
from imubench.inputs.limits import BINARY_BYTES, DEPTH, NUMBERS
from imubench.inputs.tables import listed

HEADER = 128  # bytes before the first element
DIMENSIONS, MATRIX, COMPRESSED = 5, 14, 15  # miINT32, miMATRIX, miCOMPRESSED
KNOWN = frozenset((*range(1, 8), 9, *range(12, 19)))  # kinds of data elements; SciPy trusts any other one's number
CHUNK = 1 << 20
UNPACKED_BYTES = 8 * NUMBERS


def read_mat(path: Path, names: Sequence[str]) -> dict[str, Any]:
    """Return variables of a MATLAB 5 file as SciPy reads them.

    Args:
        path: the file.
        names: the variables, which must be there.

    Raises:
        InputError: no MATLAB 5 file, damaged, a variable is missing, or it unpacks to more than the limit.
    """
    from scipy.io import loadmat, whosmat

    with opened(path, BINARY_BYTES) as file:
        _check_unpacked(path, file)
        try:
            file.seek(0)
            held = [name for name, _, _ in whosmat(file)]
            for name in names:
                if name not in held:
                    raise InputError(f"{path}: expected variable '{name}', got {listed(held) or 'nothing'}")
            file.seek(0)
            content = loadmat(file, variable_names=list(names))
            return {name: content[name] for name in names}
        except InputError:
            raise
        except Exception as error:  # the library's own errors for damaged files are of every kind
            reason = first_line(error)
            raise InputError(f"{path}: expected a MATLAB 5 .mat file, got: {reason}") from None


def _check_unpacked(path: Path, file: BinaryIO) -> None:
    """Raise `InputError` where the compressed elements hold more bytes than the limit; damage is left to the reader."""
    head = file.read(HEADER)
    if len(head) < HEADER:
        raise InputError(f"{path}: expected a MATLAB 5 .mat file, got one of {len(head)} bytes")
    order = ">" if head[126:128] == b"MI" else "<"
    left = UNPACKED_BYTES
    while len(tag := file.read(8)) == 8:
        kind, size = struct.unpack(f"{order}II", tag)
        if kind != COMPRESSED:
            _check_elements(path, memoryview(tag + file.read(size)), order)
            continue
        content = _unpacked(file.read(size), left)
        if content is None:
            raise InputError(f"{path}: expected at most {UNPACKED_BYTES >> 20} MB when unpacked, got more")
        left -= len(content)
        _check_elements(path, memoryview(content), order)


def _unpacked(content: bytes, most: int) -> bytearray | None:
    """Return the bytes of a compressed element; None where there are more than `most`."""
    found = bytearray()
    for keep in (False, True):  # counted before any of it is kept
        stream, size = zlib.decompressobj(), 0
        try:
            part = stream.decompress(content, CHUNK)
            while part:
                size += len(part)
                if size > most:
                    return None
                if keep:
                    found += part
                part = stream.decompress(stream.unconsumed_tail, CHUNK)
        except zlib.error:
            pass  # damaged: the reader says so
    return found


def _elements(view: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Yield the kind and the bytes of each data element in a row of them."""
    while len(view) >= 8:
        kind, size = struct.unpack(f"{order}II", view[:8])
        if kind >> 16:  # up to four bytes, within the tag
            yield kind & 0xFFFF, view[4 : 4 + min(kind >> 16, 4)]
            view = view[8:]
        else:
            yield kind, view[8 : 8 + size]
            view = view[8 + size + -size % 8 :]


def _check_elements(path: Path, view: memoryview, order: str, depth: int = 0) -> None:
    """Raise `InputError` for data of no known kind, too deep cells, and arrays with more entries than bytes."""
    if depth > DEPTH:
        raise InputError(f"{path}: expected cells at most {DEPTH} deep, got deeper ones")
    for kind, body in _elements(view, order):
        if kind not in KNOWN:
            raise InputError(f"{path}: expected data of a kind that MATLAB 5 knows, got {kind}")
        if kind != MATRIX:
            continue
        parts = list(_elements(body, order))
        if len(parts) > 1 and parts[1][0] == DIMENSIONS:
            sizes = struct.unpack(f"{order}{len(parts[1][1]) // 4}i", parts[1][1][: len(parts[1][1]) // 4 * 4])
            if not 0 <= prod(sizes) <= len(body):  # an entry takes a byte at least
                raise InputError(f"{path}: expected an array no larger than its part of the file, got {list(sizes)}")
        _check_elements(path, body, order, depth + 1)
