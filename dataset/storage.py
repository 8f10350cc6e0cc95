"""Where a dataset is written: a folder whose files are there completely or not at all.

Another kind of place is another class with these methods and a way to be told by its path.
"""

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from imubench.atomic import atomic_file
from imubench.errors import InputError


class Folder:
    """A folder on a disk of this machine, or on one that all workers share."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.root = Path(path)

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """Hand out a path to write to; on a clean exit its content is on the disk and then has its name.

        Raises `InputError` where that is not possible: no permission, a full disk.
        """
        try:
            with atomic_file(self.root / name) as partial:
                yield partial
        except OSError as error:
            raise cannot_write(self.root / name, error) from None

    def write(self, name: str, content: bytes) -> None:
        """Write a small file."""
        with self.writing(name) as path:
            path.write_bytes(content)

    def read(self, name: str) -> bytes:
        """Return a file's content; `InputError` where it cannot be read."""
        try:
            return (self.root / name).read_bytes()
        except OSError as error:
            raise InputError(f"{self.root / name}: expected a readable file, got: {error.strerror}") from None

    def read_json(self, name: str) -> dict[str, Any] | None:
        """Return a table of JSON, or None where there is none or something else."""
        try:
            found = json.loads((self.root / name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return found if isinstance(found, dict) else None

    def size(self, name: str) -> int | None:
        """Return a file's size in bytes; None where there is no such file."""
        try:
            return (self.root / name).stat().st_size
        except OSError:
            return None

    def sha256(self, name: str) -> str:
        """Return the hash of a file; `InputError` where it cannot be read."""
        try:
            with (self.root / name).open("rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest()
        except OSError as error:
            raise InputError(f"{self.root / name}: expected a readable file, got: {error.strerror}") from None

    def names(self) -> list[str]:
        """Return the names of all files, hidden ones included, in order."""
        files = (Path(where, name) for where, _, names in os.walk(self.root) for name in names)
        return sorted(file.relative_to(self.root).as_posix() for file in files)

    def remove(self, name: str) -> None:
        """Remove a file, and its folder if nothing is left in it."""
        with suppress(OSError):
            (self.root / name).unlink()
            (self.root / name).parent.rmdir()


def cannot_write(path: Path, error: OSError) -> InputError:
    """Return the error for a place that takes no data."""
    reason = error.strerror or str(error).rpartition("] ")[2]  # Arrow has it at the end of a line of its own
    return InputError(f"{path}: expected a place that can be written, got: {reason}")
