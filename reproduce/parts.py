"""Parts of experiments on all cores, with what is finished kept on the disk, so that an interrupted run goes on.

What is being computed when a run is stopped is computed again by the next one; what was finished is not.
"""

import hashlib
import json
import shutil
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, wait
from contextlib import suppress
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

import numpy as np

import imubench
from imubench.atomic import atomic_file
from imubench.inputs.files import opened, real
from imubench.inputs.limits import BINARY_BYTES
from imubench.reproduce.paper import Arrays, Part
from imubench.workers import process_pool

COMPUTING = ("imubench.estimators", "imubench.models", "imubench.scenarios", "imubench.sim", "imubench.reproduce")

Report = Callable[[Part], None]
"""Called once for every part that is done."""


class Store:
    """Finished parts in a hidden folder beside the output; `forget` removes it."""

    def __init__(self, out: Path, settings: str, computing: Sequence[str] = COMPUTING):
        target = real(out)
        self.home = target.parent / f".{target.name}.parts"
        self.folder = self.home / _key(settings, computing)

    def load(self, name: str) -> Arrays | None:
        """Return the arrays of a finished part, or None; a broken file counts as none."""
        try:
            with opened(self._path(name), BINARY_BYTES) as file, zipfile.ZipFile(file) as parts:
                if sum(entry.file_size for entry in parts.infolist()) > BINARY_BYTES:
                    return None
                with np.load(file, allow_pickle=False) as stored:
                    return {name: stored[name] for name in stored.files}
        except Exception:  # not there, or damaged in any way: it is computed again
            return None

    def save(self, name: str, arrays: Mapping[str, object]) -> Arrays:
        """Keep the arrays of a finished part, and return them."""
        done = {key: np.asarray(value) for key, value in arrays.items()}
        with atomic_file(self._path(name)) as partial, partial.open("wb") as file:
            np.savez(file, **done)  # type: ignore[arg-type]
        return done

    def forget(self) -> None:
        """Remove the finished parts of these settings; those of a run with other settings may still be gone on with."""
        shutil.rmtree(self.folder, ignore_errors=True)
        with suppress(OSError):  # others are left
            self.home.rmdir()

    def _path(self, name: str) -> Path:
        return self.folder / f"{name}.npz"


def _key(settings: str, computing: Sequence[str]) -> str:
    """Return a name that changes with the settings and with any line of code of the packages that compute."""
    digest = hashlib.sha256(f"{imubench.__version__} {np.__version__} {settings}".encode())
    hash_code(digest, computing)
    return digest.hexdigest()[:16]


def hash_code(digest: "hashlib._Hash", packages: Iterable[str]) -> None:
    """Add every line of code of some of this project's packages to a hash."""
    for package in packages:
        for name, content in sorted(sources(files(package))):
            digest.update(f"{package}/{name}".encode() + content)


def sources(folder: Traversable) -> Iterator[tuple[str, bytes]]:
    """Yield the name and content of every file below a folder that decides about numbers."""
    for item in folder.iterdir():
        if item.is_dir():
            yield from ((f"{item.name}/{name}", content) for name, content in sources(item))
        elif item.name.endswith((".py", ".toml", ".xml")):
            yield item.name, item.read_bytes()


def run_parts(parts: Iterable[Part], store: Store, workers: int, report: Report) -> dict[str, Arrays]:
    """Return the arrays of every part by its name, from the store or computed and put there.

    With `workers` = 0 everything happens in this process.
    """
    done: dict[str, Arrays] = {}
    open_parts = []
    for part in parts:
        stored = store.load(part.name)
        if stored is None:
            open_parts.append(part)
        else:
            done[part.name] = stored
            report(part)
    if workers == 0:
        for part in open_parts:
            done[part.name] = store.save(part.name, part.run(**part.arguments))
            report(part)
    elif open_parts:
        _compute(open_parts, store, workers, report, done)
    return done


def _compute(parts: list[Part], store: Store, workers: int, report: Report, done: dict[str, Arrays]) -> None:
    with process_pool(min(workers, len(parts))) as pool:
        # The longest first, so that no core waits long at the end.
        pending = {pool.submit(p.run, **p.arguments): p for p in sorted(parts, key=lambda p: -p.work)}
        while pending:
            for future in wait(pending, return_when=FIRST_COMPLETED)[0]:
                part = pending.pop(future)
                done[part.name] = store.save(part.name, future.result())
                report(part)


def settings_text(settings: object, quick: bool) -> str:
    """Return settings as text that is the same for the same settings."""
    return json.dumps([quick, repr(settings)])
