"""One run at a time in a folder: a lock that dies with the process that holds it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from imubench.dataset.storage import cannot_write
from imubench.errors import InputError


@contextmanager
def locked(path: Path, what: str) -> Iterator[None]:
    """Hold the lock file `path`, whose folder is made; `InputError` names the process that holds it already."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise cannot_write(path, error) from None
    try:
        if not _taken(handle):
            holder = os.read(handle, 32).decode(errors="replace").strip() or "another one"
            raise InputError(
                f"{what}: expected a folder that no other run writes to, got one in use by process {holder}"
            )
        try:
            os.ftruncate(handle, 0)
            os.write(handle, f"{os.getpid()}\n".encode())
        except OSError as error:
            raise cannot_write(path, error) from None
        yield
    finally:
        os.close(handle)  # and with it the lock


def _taken(handle: int) -> bool:
    """Take the lock of an open file; return whether nobody else has it."""
    try:
        if os.name == "nt":
            import msvcrt

            os.lseek(handle, 1 << 20, os.SEEK_SET)  # beyond the text, which others may read
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
            os.lseek(handle, 0, os.SEEK_SET)
        else:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True
