"""Regular files, opened without waiting for one that is none, and names that stay below their folder."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path, PureWindowsPath
from typing import Any

from imubench.errors import InputError, shown
from imubench.inputs.limits import NAME_CHARACTERS, TEXT_BYTES

NOTHING = "nothing of that name"
KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def what_is(path: Path) -> str:
    """Return `a file`, `a folder`, `a pipe`, ... or `nothing of that name`, which a name too long for any file is too.

    Args:
        path: any path; a link counts as what it leads to.
    """
    try:
        mode = Path(path).stat().st_mode
    except (OSError, ValueError):  # ValueError: a null character
        return NOTHING
    return KINDS.get(stat.S_IFMT(mode), "a file")


def real(path: Path | str) -> Path:
    """Return an absolute path with its links followed, as far as they lead anywhere: a link to itself stays."""
    return Path(os.path.realpath(path))


@contextmanager
def opened(path: Path, most: int, content: bytes | None = None) -> Iterator[Any]:
    """Hand out a regular file of at most `most` bytes, open for reading.

    Args:
        path: the file. A pipe, a device or a socket is refused without waiting for it.
        most: bytes.
        content: what the file holds, where it was read before; nothing is opened then.

    Raises:
        InputError: nothing of that name, no regular file, too large, or not readable, also while it is read.
    """
    if content is not None:
        yield BytesIO(content)
        return
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except FileNotFoundError:
        raise InputError(f"{path}: expected a file, got nothing of that name") from None
    except IsADirectoryError:
        raise InputError(f"{path}: expected a file, got a folder") from None
    except (OSError, ValueError) as error:  # ValueError: a null character
        if what_is(path) not in ("a file", NOTHING):
            raise InputError(f"{path}: expected a file, got {what_is(path)}") from None
        raise InputError(f"{path}: expected a readable file, got: {getattr(error, 'strerror', error)}") from None
    try:
        found = os.fstat(handle)
        kind = stat.S_IFMT(found.st_mode)
        if kind != stat.S_IFREG:
            raise InputError(f"{path}: expected a file, got {KINDS.get(kind, 'something else')}")
        if found.st_size > most:
            raise InputError(f"{path}: expected a file of at most {_megabytes(most)}, got {_megabytes(found.st_size)}")
        with os.fdopen(handle, "rb", closefd=False) as file:
            yield file
    except OSError as error:
        raise InputError(f"{path}: expected a readable file, got: {error.strerror or error}") from None
    finally:
        os.close(handle)


def read_bytes(path: Path, most: int = TEXT_BYTES) -> bytes:
    """Return the content of a regular file of at most `most` bytes; `InputError` as `opened`."""
    with opened(path, most) as file:
        content = file.read(most + 1)  # it may grow meanwhile
    if len(content) > most:
        raise InputError(f"{path}: expected a file of at most {_megabytes(most)}, got a larger one")
    return content


def _megabytes(size: int) -> str:
    return f"{size / 2**20:,.0f} MB" if size >= 2**20 else f"{size:,} bytes"


def decode(content: bytes, where: str, line: int = 1) -> str:
    """Return text; `InputError` names the line of the first byte that is not UTF-8, the first being `line`."""
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        row = content.count(b"\n", 0, error.start) + line
        got = f"0x{content[error.start]:02x}"
        raise InputError(f"{where}, line {row}: expected UTF-8 text, got byte {got}") from None


def below(folder: Path, name: object, where: str, what: str = "a file below its folder") -> Path:
    """Return the path of `name` below `folder`: the one way from a name in a file to a path.

    Args:
        folder: what the path must stay below.
        name: what the file says; absolute paths, drives, `..`, control characters and no text are refused.
        where: what says so, for the message.
        what: what was expected, for the message.

    Raises:
        InputError: the name leads elsewhere, is none, or is longer than any file's.
    """
    parts = PureWindowsPath(name) if isinstance(name, str) else None  # reads both separators and drive letters
    if parts is None or not parts.parts or parts.root or parts.drive or ".." in parts.parts:
        raise InputError(f"{where}: expected {what}, got {_named(name)}")
    if not str(name).isprintable():
        raise InputError(f"{where}: expected {what}, got the control characters in {_named(name)}")
    return Path(folder) / str(name)


def inside(folder: Path, name: object, where: str, what: str = "a file inside its folder") -> Path:
    """Return the path of `name` below `folder` as `below` does, and refuse links that lead out of it.

    Raises:
        InputError: the name, or what it links to, is not inside the folder.
    """
    path = below(folder, name, where, what)
    if not real(path).is_relative_to(real(folder)):
        raise InputError(f"{where}: expected {what}, got {_named(name)}, which leads elsewhere")
    return path


def plain_name(name: object, where: str) -> str:
    """Return a name that may become that of one file or folder.

    Args:
        name: what a file says.
        where: what says so, for the message.

    Raises:
        InputError: no text, empty, hidden (`.x`), with a separator or a control character, or too long.
    """
    if not isinstance(name, str) or not name.strip() or name != name.strip() or name.startswith("."):
        raise InputError(f"{where}: expected a name for a file, got {_named(name)}")
    if not name.isprintable() or any(c in name for c in "/\\:"):
        raise InputError(f"{where}: expected a name without separators and control characters, got {_named(name)}")
    if len(name.encode()) > NAME_CHARACTERS:
        raise InputError(f"{where}: expected a name of at most {NAME_CHARACTERS} bytes, got {len(name.encode()):,}")
    return name


def _named(name: object) -> str:
    return f"'{name}'" if isinstance(name, str) and len(name) < 80 else shown(name)
