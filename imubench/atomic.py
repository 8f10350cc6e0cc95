"""Output that is there completely or not at all.

Both managers hand out a temporary sibling (hidden, `.*.partial`) of the path and rename it at the end, after
everything in it was flushed to the disk. When anything goes wrong before that, the sibling and the parents made for
it are removed and what stood at the path before is untouched. What a killed run left is removed by the next one.
On Linux an older folder and the new one change places in one step, so that there is no moment without either.

What may be replaced: a file always, for its user named it. A folder when it is empty, or when it is as we left it:
we put `.imubench.json` into it, which lists every file with its size and time of change, and a folder that holds
anything else, or that was edited, is never deleted but refused with an `InputError`. The current folder and those
above it are refused too, and so is a folder that is, holds or lies in an input. Entered before the work begins, the
manager refuses before anything is done, and keeps other runs away from the same folder meanwhile.
"""

import errno
import glob
import json
import os
import re
import shutil
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from imubench.errors import InputError
from imubench.inputs.files import NOTHING, real, what_is
from imubench.inputs.json import load_table
from imubench.inputs.limits import JSON_BYTES
from imubench.leftovers import undone
from imubench.lock import locked
from imubench.sources import folder_of

MARKER = ".imubench.json"
NOT_THE_PLACE = (ConnectionError, FileNotFoundError, FileExistsError, IsADirectoryError, NotADirectoryError)
"""Errors of the system that say nothing about whether a place can be written."""

NOT_COUNTED = (".DS_Store", "Thumbs.db")  # what file browsers leave behind by looking
NO_FLUSH = (errno.EINVAL, errno.ENOTSUP, errno.EBADF)  # what file systems say that cannot flush a folder
NO_EXCHANGE = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP)  # what systems say that cannot exchange two names
AT_FDCWD, RENAME_EXCHANGE = -100, 2  # Linux' renameat2


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Hand out a path with the suffix of `path`; what was written there is moved to `path` on a clean exit.

    Raises:
        InputError: `path` is a folder, or it cannot be written, a full disk included.
    """
    with atomic_files(path) as (partial,):
        yield partial


@contextmanager
def atomic_files(*paths: Path) -> Iterator[tuple[Path, ...]]:
    """Do as `atomic_file` with some files that belong together: the last gets its name when the others have theirs.

    Where one cannot have its name, the others get none either, as far as the system can exchange two files.
    """
    targets = [real(path) for path in paths]
    partials = [target.parent / f".{uuid4().hex[:8]}.partial.{target.name}" for target in targets]
    with ExitStack() as stack:
        for path, target, partial in zip(paths, targets, partials, strict=True):
            if what_is(target) not in ("a file", NOTHING):
                raise InputError(f"{path}: expected a file to write, got {what_is(target)}")
            for context in (writing(Path(path)), _parents(Path(path), target), _temporary(partial)):
                stack.enter_context(context)
        yield tuple(partials)
        for partial in partials:
            _flush(partial)
        with ExitStack() as back:
            for partial, target in zip(partials[:-1], targets, strict=False):
                back.callback(_back, partial, target, _number(partial), target.exists(), partials[-1])
                _name(
                    partial, target
                )  # known before how it is taken back: a signal may come as soon as it has its name
            partials[-1].replace(targets[-1])
        for folder in {target.parent for target in targets}:
            _flush_names(folder)


def _back(partial: Path, target: Path, number: int | None, replaced: bool, last: Path) -> None:
    """Take a file's name back, where it has it, unless the last of its files has its own."""
    if not last.exists() or _number(target) != number:
        return
    if not replaced:
        target.unlink()
    elif partial.exists():
        _exchanged(partial, target)


def _number(path: Path) -> int | None:
    """Return by which number the file system knows a file, None where there is none."""
    try:
        return path.stat().st_ino
    except FileNotFoundError:
        return None


def _name(partial: Path, target: Path) -> None:
    """Give a file its final name; another one that had it gets the temporary name, as far as the system can do that."""
    if not (target.exists() and _exchanged(partial, target)):
        partial.replace(target)


def remove_partial_files(path: Path) -> None:
    """Remove what runs that were killed left of an `atomic_file`; nobody may be writing it just now."""
    target = real(path)
    for left in target.parent.glob(f".*.partial.{glob.escape(target.name)}"):
        _remove(left)


@contextmanager
def atomic_directory(path: Path, inputs: Iterable[Path] = ()) -> Iterator[Path]:
    """Hand out an empty folder; it is renamed to `path` on a clean exit, and marked as ours.

    Args:
        path: the folder to write.
        inputs: files and folders that are read meanwhile.

    Raises:
        InputError: `path` is a file or a folder that may not be replaced, see above; it overlaps an input; another
            run writes to it; it cannot be written, a full disk included.
    """
    target = real(path)
    check_apart(Path(path), inputs)
    _check_replaceable(Path(path), target)
    folder = target.parent / f".{target.name}.{uuid4().hex[:8]}.partial"
    with writing(Path(path)), _parents(Path(path), target), locked(target.parent / f".{target.name}.lock", path):
        _tidy(target)
        with _temporary(folder):
            folder.mkdir()
            yield folder
            (folder / MARKER).write_text(json.dumps(_listing(folder), indent=1), encoding="utf-8")
            for where, _, names in os.walk(folder):
                for name in names:
                    _flush(Path(where, name))
                _flush(Path(where))
            _check_replaceable(Path(path), target)
            try:
                _swap(folder, target)
            except OSError as error:  # whatever it is: somebody else put something there meanwhile
                raise cannot_write(path, error) from None
            _flush_names(target.parent)


def check_apart(path: Path, inputs: Iterable[Path]) -> None:
    """Raise `InputError` where the output `path` is, holds or lies in one of the inputs, links followed.

    An input `DIR#17` is the dataset in DIR, whose recording 17 is read; a URL is apart from all folders.
    """
    own = _chain(path)
    for given in inputs:
        folder = folder_of(given)
        for place in () if folder is None else _places(folder):
            other = _chain(place)
            if own[0] == other[0]:
                how = "the input itself"
            elif own[0] in other:
                how = "one that holds the input"
            elif other[0] in own:
                how = "one inside the input"
            else:
                continue
            raise InputError(f"{path}: expected a place for the output apart from the input {given}, got {how}")


def _places(given: Path) -> list[Path]:
    """Return an input and, where it is a folder, what the links in it lead to."""
    try:
        return [given, *(entry for entry in given.iterdir() if entry.is_symlink())]
    except OSError:  # no folder, or none that can be listed
        return [given]


def _chain(path: Path) -> list[object]:
    """Return what tells a path and each folder above it from others: by device and number where it exists."""
    found: list[object] = []
    resolved = real(path)
    for place in (resolved, *resolved.parents):
        try:
            stat = place.stat()
            found.append((stat.st_dev, stat.st_ino))
        except OSError:
            found.append(str(place))
    return found


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn a place that takes no data, such as a full disk, into one line that names `path`."""
    try:
        yield
    except NOT_THE_PLACE:
        raise
    except OSError as error:
        raise cannot_write(path, error) from None


@contextmanager
def _parents(path: Path, target: Path) -> Iterator[None]:
    """Make the folders above `target`; remove those that nothing is put into."""
    missing = [parent for parent in target.parents if not parent.exists()]

    def remove() -> None:
        for parent in missing:
            with suppress(OSError):  # something is in it
                parent.rmdir()

    with undone(remove):
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise cannot_write(path, error) from None
        yield


@contextmanager
def _temporary(partial: Path) -> Iterator[None]:
    """Remove in the end what has the name of a partial file or folder."""
    with undone(lambda: _remove(partial)):
        yield


def _remove(path: Path) -> None:
    """Remove a file or folder as far as possible."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):  # never made, or renamed
            path.unlink()


def _tidy(target: Path) -> None:
    """Remove what a run that was killed left beside `target`; bring back what it had moved aside."""
    one = r"\.[0-9a-f]{8}\.(?:partial|old)"
    beside = re.compile(rf"\.\.?{re.escape(target.name)}{one}(?:{one}|\.lock)?")  # of a folder within a partial one too
    for entry in list(target.parent.iterdir()):
        if beside.fullmatch(entry.name):
            if entry.name.endswith(".old") and not target.exists():
                entry.rename(target)
            else:
                _remove(entry)


def _swap(partial: Path, target: Path) -> None:
    """Give a folder its final name; an older one gets the name of `partial`, or that of none at all."""
    if not target.exists():
        partial.rename(target)
    elif not _exchanged(partial, target):
        aside = target.parent / f".{target.name}.{uuid4().hex[:8]}.old"

        def settle() -> None:
            if aside.exists() and not target.exists():
                aside.rename(target)
            else:
                _remove(aside)

        with undone(settle):
            target.rename(aside)
            partial.rename(target)


def _exchanged(one: Path, other: Path) -> bool:
    """Exchange the names of two folders in one step; return False where the system cannot."""
    if sys.platform != "linux":
        return False
    import ctypes

    try:
        exchange = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):  # another C library
        return False
    while exchange(AT_FDCWD, os.fsencode(one), AT_FDCWD, os.fsencode(other), RENAME_EXCHANGE):
        number = ctypes.get_errno()
        if number in NO_EXCHANGE:
            return False
        if number != errno.EINTR:
            raise OSError(number, os.strerror(number), str(other))
    return True


def _check_replaceable(path: Path, target: Path) -> None:
    """Raise `InputError` unless `target` may become our folder: nothing is there, or nothing anybody would miss."""
    try:
        if not target.exists():
            return
    except OSError as error:  # a name that is too long
        raise cannot_write(path, error) from None
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
    folder = path.is_dir()
    if os.name == "nt" and folder:
        return  # Windows opens no folders
    handle = os.open(path, os.O_RDONLY if os.name != "nt" else os.O_RDWR)
    try:
        os.fsync(handle)
    except OSError as error:
        if not folder or error.errno not in NO_FLUSH:
            raise
    finally:
        os.close(handle)


def _flush_names(folder: Path) -> None:
    """Flush a folder in which something got its final name; without that, a power cut may bring back what was there."""
    with suppress(OSError):  # the result is there: nothing is lost that could be told
        _flush(folder)


def cannot_write(path: Path | str, error: OSError) -> InputError:
    """Return the error for a place that takes no data."""
    reason = (error.strerror or str(error)).rpartition("] ")[2]  # Arrow has it at the end of a line of its own
    return InputError(f"{path}: expected a place that can be written, got: {reason}")
