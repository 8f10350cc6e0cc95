"""The process that reads: one input after the other, each in a folder of its own, with its limits and its witnesses."""

import contextlib
import gc
import io
import os
import resource
import sys
import traceback
import warnings
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from time import process_time
from typing import Any

GIGABYTE = 1 << 30
LIMIT = GIGABYTE  # by which a read may grow the process
BACKSTOP = 6 * GIGABYTE  # that one call of an allocator can take before the pool, which looks on, ends the process
FILE = 2 * GIGABYTE  # that a file may grow to
HARM = {
    "read": "a file outside the input's folder",
    "wrote": "a file outside the input's folder",
    "left": "a file in the working folder",
}
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "ARROW_DEFAULT_MEMORY_POOL": "system",  # gives memory back at once, so that one input does not pay for another
    "PYTHONDONTWRITEBYTECODE": "1",
    "COLUMNS": "80",
}
"""What a worker's process must be started with."""


@dataclass(frozen=True)
class Task:
    """One input to read: its number, or its content."""

    reader: str
    seed: int = 0
    index: int = 0
    content: bytes | None = None
    command: bool = False  # the whole command, not only its reader


def work(connection: Connection) -> None:
    """Read what comes until None does; tell before each read how large this process is, and then what came of it."""
    from fuzz.scratch import Scratch

    scratch = Scratch()
    os.environ["TMPDIR"] = os.environ["MPLCONFIGDIR"] = str(scratch.tmp)
    os.chdir(scratch.cwd)
    _load()
    printed = scratch.root / "printed"
    native = os.open(printed, os.O_RDWR | os.O_CREAT | os.O_APPEND)
    os.dup2(native, 1)
    os.dup2(native, 2)
    witness = Witness(str(scratch.root))
    sys.addaudithook(witness)
    size = _status("VmData") + BACKSTOP
    resource.setrlimit(resource.RLIMIT_DATA, (size, size))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE, FILE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    connection.send(("ready", str(scratch.root)))
    while (task := connection.recv()) is not None:
        connection.send(("done", _read(task, scratch, witness, connection)))


def _load() -> None:
    """Import what the commands import when they run, so that no input pays for it."""
    import imubench.cli_diagnose
    import imubench.cli_generate
    import imubench.cli_prove
    import imubench.cli_reproduce
    import imubench.run  # noqa: F401


class Witness:
    """An audit hook that notes files which Python opens for writing, makes or removes outside a folder."""

    WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
    CHANGES = (
        "os.remove",
        "os.rename",
        "os.rmdir",
        "os.mkdir",
        "os.link",
        "os.symlink",
        "os.truncate",
        "os.chmod",
        "shutil.rmtree",
    )
    FREE = ("/dev/null", "/dev/tty", "/proc/")

    def __init__(self, root: str) -> None:
        self.root, self.watching, self.found = root, False, ""

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Note an event, as `sys.addaudithook` hands it over."""
        if not self.watching or self.found:
            return
        if event == "open":
            path, _, flags = arguments
            if isinstance(flags, int) and flags & self.WRITING:
                self._note("open", path)
        elif event in self.CHANGES:
            for path in arguments[:2] if event in ("os.rename", "os.link") else arguments[:1]:
                self._note(event, path)

    def _note(self, event: str, path: Any) -> None:
        if not isinstance(path, str | bytes | os.PathLike):
            return
        where = os.path.realpath(os.fsdecode(path))
        if not where.startswith((self.root, *self.FREE)):
            self.found = f"{event} {where}"


def _read(task: Task, scratch: Any, witness: Witness, connection: Connection) -> Any:
    from fuzz import inputs
    from fuzz.readers import READERS
    from fuzz.scratch import listing
    from fuzz.verdict import Outcome

    reader = READERS[task.reader]
    try:
        content = inputs.content(task.reader, task.seed, task.index) if task.content is None else task.content
    except Exception as error:  # a defect of the fuzzer's own
        return Outcome(
            "failed", f"mutator: {type(error).__name__}", "".join(traceback.format_exception(error))[-3_000:]
        )
    folder, out = scratch.lay_out(reader.with_target(content))
    before = listing(folder)
    os.ftruncate(1, 0)
    gc.collect(0)
    Path("/proc/self/clear_refs").write_text("5")  # the peak counts from here
    size = _status("VmRSS")
    connection.send(("begin", size))
    start = process_time()
    witness.watching, witness.found = True, ""
    try:
        outcome = _command(reader.words(folder, out)) if task.command and reader.words else _called(reader, folder, out)
    finally:
        witness.watching = False
    seconds, grown = process_time() - start, _status("VmHWM") - size
    harm = scratch.harm()
    if outcome.verdict != "failed":
        after = listing(folder)
        may = reader.writes == "always" or (reader.writes == "when accepted" and outcome.verdict == "accepted")
        if witness.found:
            outcome = Outcome("failed", "wrote: outside the input's and the output's folder", witness.found)
        elif harm and not (reader.leads_outside and harm.startswith("read")):
            outcome = Outcome("failed", harm.partition(" ")[0] + ": " + HARM[harm.partition(" ")[0]], harm)
        elif before != after and not may:
            outcome = Outcome("failed", "changed: the input", ", ".join(sorted(before.keys() ^ after.keys()))[:300])
        elif grown > LIMIT:
            outcome = Outcome("failed", "memory: over 1 GB", outcome.said)
    scratch.clear(folder, out)
    return replace(outcome, seconds=seconds, megabytes=grown / 1e6)


def _called(reader: Any, folder: Path, out: Path) -> Any:
    from fuzz.verdict import Outcome, of_exception

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            reader.read(folder, out)
    except Exception as error:
        outcome = of_exception(error)
        traceback.clear_frames(error.__traceback__)
        return outcome
    return Outcome("accepted")


def _command(words: list[str]) -> Any:
    """Run `imubench` with some words in this process."""
    from fuzz.verdict import of_command, of_exception
    from imubench.cli import main

    output, errors, code = io.StringIO(), io.StringIO(), 0
    sys.argv = ["imubench", *words]
    try:
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors), warnings.catch_warnings():
            warnings.simplefilter("always")  # a warning is a line more beside a refusal
            main()
    except SystemExit as stop:
        code = 0 if stop.code is None else stop.code
    except Exception as error:
        outcome = of_exception(error)
        traceback.clear_frames(error.__traceback__)
        return outcome
    past = os.pread(1, 3_000, 0).decode(errors="replace")  # what libraries print, a user sees beside our lines
    return of_command(code, output.getvalue(), errors.getvalue() + past)


def _status(key: str) -> int:
    """Return a figure of this process in bytes: VmRSS, VmHWM, VmData."""
    lines = Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith(key))
