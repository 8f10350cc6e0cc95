"""MATLAB files of version 5, whose compressed parts are measured before they are unpacked."""

import struct
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO

from imubench.errors import InputError, first_line
from imubench.inputs.files import opened
from imubench.inputs.limits import BINARY_BYTES, NUMBERS
from imubench.inputs.tables import listed

HEADER = 128  # bytes before the first element
COMPRESSED = 15  # miCOMPRESSED
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
            file.seek(size, 1)
            continue
        left -= _unpacked(file.read(size), left)
        if left < 0:
            raise InputError(f"{path}: expected at most {UNPACKED_BYTES >> 20} MB when unpacked, got more")


def _unpacked(content: bytes, most: int) -> int:
    """Return how many bytes a compressed element holds, or a number above `most`."""
    stream, size = zlib.decompressobj(), 0
    try:
        part = stream.decompress(content, CHUNK)
        while part and size <= most:
            size += len(part)
            part = stream.decompress(stream.unconsumed_tail, CHUNK)
    except zlib.error:
        pass  # damaged: the reader says so
    return size
