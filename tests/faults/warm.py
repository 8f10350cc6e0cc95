"""A process that has imported what is slow to import, and forks a child for every command line that it is handed.

    python warm.py MODULE ...

Each line of its input is a request in JSON, each line of its output the answer. What starts threads (Rerun) is left to
the children: a process with other threads is not forked.
"""

import ctypes
import importlib
import json
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

QUIET = ("jemalloc_bg_thd",)  # Arrow's allocator stops its own thread around a fork and starts it again


def threads() -> list[str]:
    """Return the names of the threads that would be lost in a child."""
    tasks = [task for task in Path("/proc/self/task").iterdir() if task.name != str(os.getpid())]
    names = [(task / "comm").read_text().strip() for task in tasks]
    return [name for name in names if name not in QUIET]


def served(modules: list[str]) -> dict[str, Any]:
    """Answer requests; return in a child, with the request that it is to fulfil."""
    for name in modules:
        importlib.import_module(name)
    if threads():
        sys.exit(f"threads that a fork would lose: {threads()}")
    print(json.dumps("ready"), flush=True)
    while line := sys.stdin.readline():
        asked = json.loads(line)
        child = os.fork()
        if not child:
            return asked
        print(json.dumps(ended(child, asked["limit"])), flush=True)
    os._exit(0)


def ended(child: int, limit: float) -> dict[str, Any]:
    """Wait for a child, and kill it after `limit` s; return its exit code and how long it took."""
    begun = time.monotonic()
    late = False
    while True:
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid:
            break
        if not late and time.monotonic() - begun > limit:
            late = True
            os.killpg(child, signal.SIGKILL)
        time.sleep(0.005)
    return {"code": os.waitstatus_to_exitcode(status), "late": late, "seconds": time.monotonic() - begun, "pid": child}


def begin(asked: dict[str, Any]) -> None:
    """Become the command: its folder, environment, streams and faults."""
    os.setsid()
    os.chdir(asked["folder"])
    os.environ.update(asked["environment"])
    for number, path in enumerate(("/dev/null", asked["said"], asked["errors"])):
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        os.dup2(handle, number)
        os.close(handle)
    ctypes.CDLL(None).faults_begin()
    if asked["prelude"]:
        module, _, function = asked["prelude"].partition(":")
        getattr(importlib.import_module(module), function)()
    sys.argv = ["imubench", *asked["line"]]


if __name__ == "__main__":
    begin(served(sys.argv[1:]))
    from imubench.main import main

    main()
