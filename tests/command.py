"""The command line, run as people run it: in a process of its own; or in this one, where that makes no difference."""

import io
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from dataclasses import dataclass
from pathlib import Path

from imubench.main import main
from imubench.signals import HANDLED


def imubench(*words: object, folder: Path, limit: float, **environment: str) -> subprocess.CompletedProcess[str]:
    """Return what `imubench` came to in a folder, with more in its environment, stopped after `limit` s."""
    command = [sys.executable, "-m", "imubench", *map(str, words)]
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=limit, env={**os.environ, **environment}
    )


@dataclass(frozen=True)
class Done:
    """How a command line ended."""

    code: int
    out: str
    err: str


def here(*words: object, folder: Path | None = None) -> Done:
    """Return what `imubench` came to in this process, in a folder; the process is afterwards as it was."""
    before = sys.argv, sys.stdout, sys.stderr
    streams = [io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2)]
    with own_signals(), chdir(folder or Path.cwd()):
        sys.argv, sys.stdout, sys.stderr = ["imubench", *map(str, words)], *streams
        try:
            main()
        except SystemExit as ended:
            code = ended.code
        finally:
            sys.argv, sys.stdout, sys.stderr = before
    assert isinstance(code, int)
    return Done(code, *(stream.buffer.getvalue().decode() for stream in streams))  # type: ignore[attr-defined]


@contextmanager
def own_signals() -> Iterator[None]:
    """Have the signals mean afterwards what they meant before: a command leaves them ignored."""
    numbers = [getattr(signal, name) for name in HANDLED if hasattr(signal, name)]
    before, hook = {number: signal.getsignal(number) for number in numbers}, sys.unraisablehook
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        sys.unraisablehook = hook
