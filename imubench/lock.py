"""One run at a time: a lock file that dies with the process that holds it."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from imubench.errors import InputError
from imubench.leftovers import undone


@contextmanager
def locked(path: Path, what: object) -> Iterator[None]:
    """Hold the lock file `path`, which is removed afterwards.

    Args:
        path: the file, in a folder that exists; it holds the number of the process.
        what: what is locked, for the message.

    Raises:
        InputError: another process, or another part of this one, holds it.
        OSError: the file cannot be made.
    """
    handles: list[int] = []

    def release() -> None:
        with suppress(OSError):  # a signal may have come before the opened file was noted, or locked
            handle = handles.pop() if handles else os.open(path, os.O_RDWR)
            try:
                if _taken(handle) and _is_still(path, handle):  # nobody may remove another holder's
                    path.unlink()  # before it is let go
            finally:
                os.close(handle)  # and with it the lock

    with undone(release):
        _hold(path, what, handles)
        os.ftruncate(handles[0], 0)
        os.write(handles[0], f"{os.getpid()}\n".encode())
        yield


def _hold(path: Path, what: object, handles: list[int]) -> None:
    """Put the handle of the lock file into `handles`, and lock it; see `locked`."""
    while True:
        handles.append(os.open(path, os.O_RDWR | os.O_CREAT, 0o644))
        if not _taken(handles[0]):
            holder = os.read(handles[0], 32).decode(errors="replace").strip() or "another one"
            raise InputError(
                f"{what}: expected a place that no other run writes to, got one in use by process {holder}"
            )
        if _is_still(path, handles[0]):
            return
        os.close(handles.pop())  # its holder removed it between the opening and the locking


def _is_still(path: Path, handle: int) -> bool:
    """Return whether an open file still has its name."""
    try:
        return os.path.samestat(path.stat(), os.fstat(handle))
    except OSError:
        return False


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
    except OSError as error:
        return error.errno not in (errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK)  # else: a file system without locks
    return True
