"""Places by URL, through fsspec: object stores and whatever else it knows (`s3://`, `gs://`, `file://`, `memory://`)."""

import hashlib
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any
from uuid import uuid4

from imubench.dataset.storage import Folder, Place
from imubench.errors import InputError, first_line
from imubench.inputs.limits import JSON_BYTES


def place(path: str) -> Place:
    """Return the place of a path or URL; `InputError` for a URL that cannot be followed here."""
    return Remote(path) if "://" in path else Folder(path)


class Remote(Place):
    """A place by URL. Files are made on a local disk, sent under a hidden name, and renamed when they are complete."""

    def __init__(self, path: str) -> None:
        self.path = path
        try:
            import fsspec
        except ImportError:
            raise InputError(f"{path}: a URL needs fsspec; install it with: pip install 'imubench[remote]'") from None
        try:
            self.system, root = fsspec.url_to_fs(path)
        except (ImportError, ValueError) as error:  # no package for the protocol, or none such
            raise InputError(f"{path}: expected a URL that fsspec can follow, got: {first_line(error)}") from None
        self.root = root.rstrip("/")

    def _at(self, name: str) -> str:
        return f"{self.root}/{name}"

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """Hand out a path on the local disk; on a clean exit its content is sent and then has its name."""
        target = self._at(name)
        parent, _, last = target.rpartition("/")
        partial = f"{parent}/.{uuid4().hex[:8]}.partial.{last}"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, last)
            try:
                yield path
                self.system.makedirs(parent, exist_ok=True)
                self.system.put_file(str(path), partial)
                self.system.mv(partial, target)
            except InputError:
                raise
            except Exception as error:  # every protocol's package has errors of its own
                with suppress(Exception):
                    self.system.rm(partial)
                where = f"{self.path}/{name}"
                raise InputError(f"{where}: expected a place that can be written, got: {first_line(error)}") from error

    @contextmanager
    def reading(self, name: str) -> Iterator[IO[bytes]]:
        """Hand out the open file, which fetches what is asked for; `InputError` where there is none."""
        where = f"{self.path}/{name}"
        if self.size(name) is None:  # such as a pipe, which whoever opens it would wait for
            raise InputError(f"{where}: expected a file, got none")
        try:
            file = self.system.open(self._at(name), "rb")
        except OSError as error:
            raise InputError(f"{where}: expected a readable file, got: {first_line(error)}") from None
        with file:
            yield file

    def read(self, name: str) -> bytes:
        """Return a file's content; `InputError` where it cannot be read."""
        with self._readable(name) as file:
            content = bytes(file.read(JSON_BYTES + 1))
        if len(content) > JSON_BYTES:
            raise InputError(f"{self.path}/{name}: expected a file of at most {JSON_BYTES >> 20} MB, got a larger one")
        return content

    def size(self, name: str) -> int | None:
        """Return a file's size in bytes; None where there is no such file."""
        self.system.invalidate_cache()  # others write here too
        try:
            found: Any = self.system.info(self._at(name))
        except OSError:  # nothing of that name, or a link to itself
            return None
        return int(found["size"]) if found["type"] == "file" else None

    def sha256(self, name: str) -> str:
        """Return the hash of a file; `InputError` where it cannot be read."""
        digest = hashlib.sha256()
        with self._readable(name) as file:
            while block := file.read(1 << 22):
                digest.update(block)
        return digest.hexdigest()

    def names(self) -> list[str]:
        """Return the names of all files, hidden ones included, in order."""
        self.system.invalidate_cache()
        return sorted(path[len(self.root) + 1 :] for path in self.system.find(self.root))

    def entries(self) -> set[str]:
        """Return the names of files and folders at the top; none where nothing is there, `InputError` of a file."""
        self.system.invalidate_cache()
        try:
            is_file = self.system.isfile(self.root)
            found = [] if is_file else self.system.ls(self.root, detail=False)
        except FileNotFoundError:
            return set()
        except Exception as error:  # the first look at the storage: no network, no key
            raise InputError(f"{self.path}: expected a place that can be listed, got: {first_line(error)}") from error
        if is_file:
            raise InputError(f"{self.path}: expected a folder to write, got a file of that name")
        return {path.rstrip("/").rpartition("/")[2] for path in found}

    def remove(self, names: list[str]) -> None:
        """Remove files."""
        with suppress(FileNotFoundError):
            if names:
                self.system.rm([self._at(name) for name in names])

    @contextmanager
    def _readable(self, name: str) -> Iterator[IO[bytes]]:
        try:
            with self.reading(name) as file:
                yield file
        except OSError as error:
            raise InputError(f"{self.path}/{name}: expected a readable file, got: {first_line(error)}") from None
