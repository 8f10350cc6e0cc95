"""Which functions of the package the readers of the fuzzer enter, seen by Python's profiler."""

import contextlib
import os
import sys
import tempfile
import tomllib
from pathlib import Path
from types import FrameType
from typing import Any

from fuzz import inputs
from fuzz.readers import READERS

ROOT = Path(__file__).resolve().parent.parent
BROKEN = 8  # inputs of each reader beside the valid one: some functions only say what is wrong


def reached() -> set[str]:
    """Return `module:function` of everything that was entered."""
    packages = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-dir"]
    modules = {ROOT / folder: package for package, folder in packages.items()}
    seen: set[tuple[str, str]] = set()

    def note(frame: FrameType, event: str, argument: Any) -> None:
        if event == "call":
            seen.add((frame.f_code.co_filename, frame.f_code.co_name))

    with tempfile.TemporaryDirectory() as home:
        os.chdir(home)
        for reader in READERS.values():
            valid = reader.files()[reader.target]
            for number, content in enumerate((valid, *(inputs.content(reader, 11, i) for i in range(BROKEN)))):
                folder = Path(home, f"{reader.name}-{number}")
                for name, one in reader.with_target(content).items():
                    path = folder / name
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.write_bytes(one)
                sys.setprofile(note)  # each time: Python drops it where a call of it fails, as in too deep a recursion
                with contextlib.suppress(Exception):  # what comes of it is judged elsewhere
                    reader.read(folder, Path(home, f"{reader.name}-{number}-out"))
        sys.setprofile(None)
        os.chdir(ROOT)
    found = set()
    for file, function in seen:
        path = Path(file)
        if path.parent in modules:
            package = modules[path.parent]
            found.add(f"{package if path.stem == '__init__' else f'{package}.{path.stem}'}:{function}")
    return found
