"""Small valid inputs of every reader, made by the project's own writers; each function returns files by their names."""

from collections.abc import Callable, Mapping
from functools import lru_cache, wraps
from pathlib import Path
from tempfile import TemporaryDirectory

Files = Mapping[str, bytes]
"""The files of one input, by their names below its folder."""


def laid_out(make: Callable[[Path], None]) -> Callable[[], Files]:
    """Return the function that gives the files which `make` writes into an empty folder; they are made once."""

    @wraps(make)
    @lru_cache(maxsize=1)
    def files() -> Files:
        with TemporaryDirectory() as temporary:
            folder = Path(temporary).resolve()
            make(folder)
            found = sorted(path for path in folder.rglob("*") if path.is_file())
            return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}

    return files


STAMP = 10**18
"""ns since 1970: the time of change of every file of an input, wherever and whenever it is laid out."""
