"""Where a dataset is written: a place whose files are there completely or not at all.

Another kind of place is another `Place` and a way to be told by its path, in `remote.place`.
"""

import hashlib
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from imubench.atomic import atomic_file, cannot_write
from imubench.errors import InputError
from imubench.inputs.files import inside, opened, read_bytes
from imubench.inputs.json import parse_json
from imubench.inputs.limits import JSON_BYTES

LARGEST = 2**63 - 1  # bytes of a file that is hashed block by block, and so takes no memory


class Place(ABC):
    """Files by name, in folders by `/`."""

    path: str  # as it was given

    @abstractmethod
    def writing(self, name: str) -> AbstractContextManager[Path]:
        """Hand out a local path to write to; on a clean exit its content is kept and then has its name.

        Raises `InputError` where that is not possible: no permission, a full disk.
        """

    @abstractmethod
    def reading(self, name: str) -> AbstractContextManager[Path | IO[bytes]]:
        """Hand out what Parquet readers take, without reading it; `InputError` from a place that has none."""

    @abstractmethod
    def read(self, name: str) -> bytes:
        """Return a file's content; `InputError` where it cannot be read."""

    @abstractmethod
    def size(self, name: str) -> int | None:
        """Return a file's size in bytes; None where there is no such file."""

    @abstractmethod
    def sha256(self, name: str) -> str:
        """Return the hash of a file; `InputError` where it cannot be read."""

    @abstractmethod
    def names(self) -> list[str]:
        """Return the names of all files, hidden ones included, in order."""

    @abstractmethod
    def entries(self) -> set[str]:
        """Return the names of files and folders at the top; none where nothing is there, `InputError` of a file."""

    @abstractmethod
    def remove(self, names: list[str]) -> None:
        """Remove files, and on a disk their folder if nothing is left in it."""

    def write(self, name: str, content: bytes) -> None:
        """Write a small file."""
        with self.writing(name) as path:
            path.write_bytes(content)

    def read_json(self, name: str) -> dict[str, Any] | None:
        """Return a table of JSON, or None where there is none or something else."""
        try:
            found = parse_json(self.read(name), f"{self.path}/{name}")
        except InputError:
            return None
        return found if isinstance(found, dict) else None


class Folder(Place):
    """A folder on a disk of this machine, or on one that all workers share."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.root = Path(path)

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """Hand out a path beside the file's; on a clean exit its content is on the disk and then has its name."""
        with atomic_file(inside(self.root, name, self.path)) as partial:
            yield partial

    @contextmanager
    def reading(self, name: str) -> Iterator[Path]:
        """Hand out the file's path."""
        yield self.root / name

    def read(self, name: str) -> bytes:
        """Return a file's content; `InputError` where it cannot be read."""
        return read_bytes(self.root / name, JSON_BYTES)

    def size(self, name: str) -> int | None:
        """Return a file's size in bytes; None where there is no such file."""
        try:
            return (self.root / name).stat().st_size
        except OSError:
            return None

    def sha256(self, name: str) -> str:
        """Return the hash of a file; `InputError` where it cannot be read."""
        with opened(self.root / name, LARGEST) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()

    def names(self) -> list[str]:
        """Return the names of all files, hidden ones included, in order."""
        files = (Path(where, name) for where, _, names in os.walk(self.root) for name in names)
        return sorted(file.relative_to(self.root).as_posix() for file in files)

    def entries(self) -> set[str]:
        """Return the names of files and folders at the top; none where nothing is there, `InputError` of a file."""
        try:
            if not self.root.exists():
                return set()
            if not self.root.is_dir():
                raise InputError(f"{self.path}: expected a folder to write, got a file of that name")
            return {path.name for path in self.root.iterdir()}
        except OSError as error:
            raise cannot_write(self.root, error) from None

    def remove(self, names: list[str]) -> None:
        """Remove files, and their folder if nothing is left in it."""
        for name in names:
            with suppress(OSError):
                (self.root / name).unlink()
                (self.root / name).parent.rmdir()


def described(path: Path) -> dict[str, Any]:
    """Return what a manifest says of a file: {"sha256", "bytes"}."""
    with path.open("rb") as file:
        return {"sha256": hashlib.file_digest(file, "sha256").hexdigest(), "bytes": path.stat().st_size}
