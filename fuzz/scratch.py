"""Where one input is laid out, and what lies beside it: files that no reader may open, write or remove.

/tmp/imubench-fuzz/w07/          a worker's own, held by a lock
    i0000042/                    the input
    o0000042                     where its command may write
    cwd/  tmp/                   the working folder, which stays empty; temporary files
    outside/kept.csv, ...        valid files, to be left alone
"""

import fcntl
import os
import resource
import shutil
from collections.abc import Callable
from pathlib import Path

from fuzz.mutate import nasty
from fuzz.seeds import STAMP, Files

HOME = Path(nasty.OUTSIDE).parent.parent
MOST = 100  # workers on one machine, of all runs together
Listing = dict[str, tuple[int, int, int]]
"""Size in bytes, time of change in ns and inode of every file and folder by its relative path."""


class Scratch:
    """A folder of one process, which nobody else uses as long as the process lives."""

    def __init__(self, kept: Files) -> None:
        """Take a folder; `kept` are the files outside, each what a reader would accept."""
        self.kept = kept
        HOME.mkdir(mode=0o777, exist_ok=True)
        for number in range(1, MOST):
            self.root = HOME / f"w{number:02d}"
            self._lock = (HOME / f"{self.root.name}.lock").open("w")
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except OSError:
                self._lock.close()
        else:
            raise OSError(f"{HOME}: expected a free folder, got {MOST - 1} in use")
        shutil.rmtree(self.root, ignore_errors=True)
        self.outside, self.cwd, self.tmp = (self.root / name for name in ("outside", "cwd", "tmp"))
        for folder in (self.outside, self.cwd, self.tmp):
            folder.mkdir(parents=True)
        self.count = 0
        self._before: dict[str, tuple[int, int, int]] = {}

    def lay_out(self, files: Files) -> tuple[Path, Path]:
        """Write an input into a new folder; return the folder and a path beside it for what comes of it."""
        self.count += 1
        self._restore()
        folder, out = self.root / f"i{self.count:07d}", self.root / f"o{self.count:07d}"
        mine = str(self.root).encode()
        for name, content in files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.replace(str(Path(nasty.OUTSIDE).parent).encode(), mine))
            os.utime(path, ns=(STAMP, STAMP))
        self._rewind()
        self._before = self._state()
        return folder, out

    def _restore(self) -> None:
        """Put the files outside in place, where the last input has harmed them."""
        if self._state() == self._before and self._before:
            return
        shutil.rmtree(self.outside)
        self.outside.mkdir()
        for name, content in self.kept.items():
            (self.outside / name).write_bytes(content)

    def clear(self, *paths: Path) -> None:
        """Remove an input and what came of it."""
        for path in (*paths, *self.cwd.iterdir(), *self.tmp.iterdir()):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)

    def harm(self) -> str:
        """Return what was done to the files outside and the working folder since `lay_out`; empty: nothing."""
        now = self._state()
        for name in self._before.keys() | now.keys():
            if self._before.get(name) != now.get(name):
                both = name in now and name in self._before and self._before[name][1:] == now[name][1:]
                return f"read {name} outside" if both else f"wrote {name} outside"
        left = [path.name for path in self.cwd.iterdir()]
        return f"left {left[0]} in the working folder" if left else ""

    def _rewind(self) -> None:
        """Put the last read of each file outside before its change: a file system then notes the next one."""
        for path in self.outside.iterdir():
            stat = path.stat()
            if stat.st_atime_ns >= stat.st_mtime_ns:
                os.utime(path, ns=(stat.st_mtime_ns - 10**10, stat.st_mtime_ns))

    def _state(self) -> dict[str, tuple[int, int, int]]:
        """Return when each file outside was last read and changed, and its size."""
        stats = {path.name: path.stat() for path in self.outside.iterdir()}
        return {name: (stat.st_atime_ns, stat.st_mtime_ns, stat.st_size) for name, stat in sorted(stats.items())}


def notes_reads(folder: Path) -> bool:
    """Return whether the file system of a folder notes when a file was read."""
    file = folder / "probe"
    file.write_bytes(b"x")
    os.utime(file, ns=(0, STAMP))
    file.read_bytes()
    noted = file.stat().st_atime_ns > 0
    file.unlink()
    return noted


def listing(folder: Path) -> Listing:
    """Return what is in a folder."""
    found: Listing = {}
    for where, folders, names in os.walk(folder):
        for name in (*folders, *names):
            path = Path(where, name)
            stat = path.lstat()
            of_file = (0, 0) if name in folders else (stat.st_size, stat.st_mtime_ns)
            found[path.relative_to(folder).as_posix()] = (*of_file, stat.st_ino)
    return found


ENDLESS = 10 << 30  # bytes of a file that takes no room on the disk


def _sparse(path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))  # the limit is for what readers write
    try:
        with path.open("wb") as file:
            file.truncate(ENDLESS)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


PLACES: dict[str, Callable[[Path], object]] = {
    "nothing": lambda path: None,
    "folder": Path.mkdir,
    "pipe": os.mkfifo,
    "device": lambda path: path.symlink_to("/dev/zero"),
    "loop": lambda path: path.symlink_to(path),
    "sparse": _sparse,
}
"""What may stand in the place of a file; a pipe that nobody writes to keeps whoever opens it waiting."""
