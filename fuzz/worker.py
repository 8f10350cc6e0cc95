"""The process that reads: one input after the other, each in a folder of its own, with its limits and its witnesses."""

import contextlib
import gc
import io
import os
import resource
import sys
import tempfile
import traceback
import warnings
from dataclasses import dataclass, replace
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from time import process_time
from typing import Any

GIGABYTE = 1 << 30
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
class Limits:
    """What one input may take."""

    seconds: float = 20.0  # of processor time, or of waiting
    memory: int = GIGABYTE  # bytes by which the process may grow


@dataclass(frozen=True)
class Task:
    """One input to read: its number, its content, or what stands in the place of its file."""

    reader: str
    seed: int = 0
    index: int = 0
    content: bytes | None = None
    place: str = ""  # a name of `scratch.PLACES`
    command: bool = False  # the whole command, not only its reader


def work(connection: Connection, limits: Limits, readers: str) -> None:
    """Read what comes until None does; tell before each read how large this process is, and then what came of it.

    `readers` is the module whose `READERS` the tasks name; its `outside` gives the files that no reader may touch.
    """
    from fuzz.scratch import Scratch

    known = import_module(readers)
    scratch = Scratch(known.outside())
    os.environ["TMPDIR"] = os.environ["MPLCONFIGDIR"] = tempfile.tempdir = str(scratch.tmp)
    os.chdir(scratch.cwd)
    printed = scratch.root / "printed"
    native = os.open(printed, os.O_RDWR | os.O_CREAT | os.O_APPEND)
    os.dup2(native, 1)
    os.dup2(native, 2)
    witness = Witness(str(scratch.root))
    sys.addaudithook(witness)
    size = _status("VmData") + BACKSTOP
    resource.setrlimit(resource.RLIMIT_DATA, (size, size))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(EOFError, BrokenPipeError):  # the pool is gone
        while (task := connection.recv()) is not None:
            connection.send(("done", _read(known.READERS[task.reader], task, limits, scratch, witness, connection)))


class Witness:
    """An audit hook that notes files which Python opens for writing, makes or removes outside a folder.

    What lies in `outside/` may not even be opened for reading. What libraries do past Python, the files there tell.
    """

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
        self.outside = f"{root}/outside/"
        self.root, self.watching, self.wrote, self.read = root, False, "", ""

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Note an event, as `sys.addaudithook` hands it over."""
        if not self.watching or self.wrote:
            return
        if event == "open":
            path, _, flags = arguments
            if isinstance(flags, int) and flags & self.WRITING:
                self._note("open", path)
            elif isinstance(path, str) and "outside" in path and os.path.realpath(path).startswith(self.outside):
                self.read = self.read or path
        elif event in self.CHANGES:
            for path in arguments[:2] if event in ("os.rename", "os.link") else arguments[:1]:
                self._note(event, path)

    def _note(self, event: str, path: Any) -> None:
        if not isinstance(path, str | bytes | os.PathLike):
            return
        where = os.path.realpath(os.fsdecode(path))
        if event == "os.mkdir" and Path(where).is_dir():
            return  # `mkdir(exist_ok=True)`, which does nothing
        if where.startswith(self.outside) or not where.startswith((f"{self.root}/", *self.FREE)):
            self.wrote = f"{event} {where}"


def _read(reader: Any, task: Task, limits: Limits, scratch: Any, witness: Witness, connection: Connection) -> Any:
    from fuzz import inputs
    from fuzz.scratch import PLACES, listing
    from fuzz.verdict import Outcome

    try:
        content = inputs.content(reader, task.seed, task.index) if task.content is None else task.content
    except Exception as error:  # a defect of the fuzzer's own
        return Outcome(
            "failed", f"mutator: {type(error).__name__}", "".join(traceback.format_exception(error))[-3_000:]
        )
    folder, out = scratch.lay_out(reader.with_target(content))
    if task.place:
        (folder / reader.target).unlink()
        PLACES[task.place](folder / reader.target)
    before = listing(folder)
    os.ftruncate(1, 0)
    gc.collect(0)
    Path("/proc/self/clear_refs").write_text("5")  # the peak counts from here
    size = _status("VmRSS")
    connection.send(("begin", size))
    start = process_time()
    witness.watching, witness.wrote, witness.read = True, "", ""
    try:
        outcome = (_command if task.command and reader.words else _called)(reader, folder, out, scratch.tmp)
    finally:
        witness.watching = False
    seconds, grown = process_time() - start, _status("VmHWM") - size
    harm = scratch.harm()
    if outcome.verdict != "failed":
        kind = harm.partition(" ")[0]
        may = reader.writes == "always" or (reader.writes == "when accepted" and outcome.verdict == "accepted")
        changed = sorted(name for name, _ in before.items() ^ listing(folder).items())
        if witness.wrote:
            outcome = Outcome("failed", f"wrote: {HARM['wrote']}", witness.wrote)
        elif harm and not (reader.leads_outside and kind == "read"):
            outcome = Outcome("failed", f"{kind}: {HARM[kind]}", harm)
        elif witness.read and not reader.leads_outside:
            outcome = Outcome("failed", f"read: {HARM['read']}", witness.read)
        elif changed and not may:
            outcome = Outcome("failed", "changed: the input", ", ".join(changed)[:300])
        elif grown > limits.memory:
            outcome = Outcome("failed", "memory: over the limit", outcome.said)
    scratch.clear(folder, out)
    return replace(outcome, seconds=seconds, megabytes=grown / 1e6)


def _called(reader: Any, folder: Path, out: Path, temporary: Path) -> Any:
    """Call a reader."""
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


def _command(reader: Any, folder: Path, out: Path, temporary: Path) -> Any:
    """Run `imubench` with a reader's words in this process."""
    from fuzz.verdict import Outcome, of_command, of_exception
    from imubench.main import main

    output, errors, code = io.StringIO(), io.StringIO(), 0
    try:
        if reader.long is not None and reader.long(folder):
            return Outcome("accepted")
        sys.argv = ["imubench", *reader.words(folder, out)]
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
    traces = sorted(temporary.glob("imubench-trace-*.txt"))
    trace = traces[-1].read_text(encoding="utf-8", errors="replace") if traces else ""
    return of_command(code, output.getvalue(), errors.getvalue() + past, trace)


def _status(key: str) -> int:
    """Return a figure of this process in bytes: VmRSS, VmHWM, VmData."""
    lines = Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith(key))
