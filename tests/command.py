"""The command line, run as people run it: in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path


def imubench(*words: object, folder: Path, limit: float, **environment: str) -> subprocess.CompletedProcess[str]:
    """Return what `imubench` came to in a folder, with more in its environment, stopped after `limit` s."""
    command = [sys.executable, "-m", "imubench", *map(str, words)]
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=limit, env={**os.environ, **environment}
    )
