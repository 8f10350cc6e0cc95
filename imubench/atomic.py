"""Output that is there completely or not at all.

Both managers hand out a temporary sibling (hidden, `.*.partial`) of the path and rename it at the end, after
everything in it was flushed to the disk. When anything goes wrong before that, the sibling and the parents made for
it are removed and what stood at the path before is untouched.

What may be replaced: a file always, for its user named it. A folder when it is empty, or when it is as we left it:
we put `.imubench.json` into it, which lists every file with its size and time of change, and a folder that holds
anything else, or that was edited, is never deleted but refused with an `InputError`. The current folder and those
above it are refused too.
"""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from imubench.errors import InputError
from imubench.inputs.json import load_table
from imubench.inputs.limits import JSON_BYTES

MARKER = ".imubench.json"
NOT_COUNTED = (".DS_Store", "Thumbs.db")  # what file browsers leave behind by looking


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Hand out a path with the suffix of `path`; what was written there is moved to `path` on a clean exit.

    Raises `InputError` when `path` is a folder or its parent cannot be written.
    """
    target = Path(path).resolve()
    if target.is_dir():
        raise InputError(f"{path}: expected a file to write, got a folder")
    with _temporary(Path(path), target, f".{uuid4().hex[:8]}.partial.{target.name}") as partial:
        yield partial
        _flush(partial)
        partial.replace(target)
        _flush(target.parent)


@contextmanager
def atomic_directory(path: Path) -> Iterator[Path]:
    """Hand out an empty folder; it is renamed to `path` on a clean exit, and marked as ours.

    An older folder is moved aside for the moment of the renaming and moved back if that fails.
    Raises `InputError` when `path` is a file or a folder that may not be replaced, see above.
    """
    target = Path(path).resolve()
    _check_replaceable(Path(path), target)
    with _temporary(Path(path), target, f".{target.name}.{uuid4().hex[:8]}.partial") as partial:
        try:
            partial.mkdir()
        except OSError as error:
            raise _cannot_write(Path(path), error) from None
        yield partial
        (partial / MARKER).write_text(json.dumps(_listing(partial), indent=1), encoding="utf-8")
        for folder, _, names in os.walk(partial):
            for name in names:
                _flush(Path(folder, name))
            _flush(Path(folder))
        _check_replaceable(Path(path), target)
        _swap(Path(path), partial, target)
        _flush(target.parent)


@contextmanager
def _temporary(path: Path, target: Path, name: str) -> Iterator[Path]:
    """Hand out the sibling `name` of `target` in a parent that exists; on an error remove it and new parents."""
    missing = [parent for parent in target.parents if not parent.exists()]
    partial = target.parent / name
    try:
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _cannot_write(path, error) from None
        yield partial
    except BaseException:
        if partial.is_dir():
            shutil.rmtree(partial, ignore_errors=True)
        else:
            with suppress(OSError):  # not made yet, or its parent is a file
                partial.unlink()
        for parent in missing:
            with suppress(OSError):  # someone else may have put something there meanwhile
                parent.rmdir()
        raise


def _swap(path: Path, partial: Path, target: Path) -> None:
    aside = target.parent / f".{target.name}.{uuid4().hex[:8]}.old"
    there = target.exists()
    try:
        if there:
            target.rename(aside)
        partial.rename(target)
    except OSError as error:
        if there and aside.exists() and not target.exists():
            aside.rename(target)
        raise _cannot_write(path, error) from None
    if there:
        shutil.rmtree(aside, ignore_errors=True)


def _check_replaceable(path: Path, target: Path) -> None:
    """Raise `InputError` unless `target` may become our folder: nothing is there, or nothing anybody would miss."""
    try:
        if not target.exists():
            return
    except OSError as error:  # a name that is too long
        raise _cannot_write(path, error) from None
    if not target.is_dir():
        raise InputError(f"{path}: expected a folder to write, got a file of that name")
    here = Path.cwd()
    if target in (here, *here.parents):
        raise InputError(f"{path}: expected a folder of its own for the output, got the current folder or one above it")
    found = _listing(target)
    try:
        ours = load_table(target / MARKER, JSON_BYTES)
    except InputError:
        ours = {}
    foreign = next((name for name, stamp in found.items() if ours.get(name) != stamp), None)
    if foreign is not None:
        what = "a changed" if foreign in ours else "a foreign"
        raise InputError(
            f"{path}: expected a new or empty folder, or one as imubench left it, got one with {what} file '{foreign}'"
        )


def _listing(folder: Path) -> dict[str, list[int]]:
    """Return [size in bytes, time of change in ns] of every file below `folder` by its relative path."""
    files = (Path(where, name) for where, _, names in os.walk(folder) for name in names)
    listing = {}
    for file in sorted(files):
        name = file.relative_to(folder).as_posix()
        if name != MARKER and file.name not in NOT_COUNTED:
            stat = file.lstat()
            listing[name] = [stat.st_size, stat.st_mtime_ns]
    return listing


def _flush(path: Path) -> None:
    """Wait until a file, or a folder's list of names, is on the disk."""
    if os.name == "nt" and path.is_dir():
        return  # Windows opens no folders
    handle = os.open(path, os.O_RDONLY if os.name != "nt" else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _cannot_write(path: Path, error: OSError) -> InputError:
    return InputError(f"{path}: expected a place that can be written, got: {error.strerror or error}")
