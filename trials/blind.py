"""A diagnosis in a process of its own, which has the recording and nothing else."""

import hashlib
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from time import perf_counter

from imubench.atomic import atomic_file
from imubench.errors import InputError
from imubench.inputs.json import load_table
from imubench.trials.guard import NOTE
from imubench.trials.replayed import MODEL
from imubench.workers import THREADS, die_with_parent

OURS = "imubench diagnose {recording} --out {out}"
NAMESPACES = ("unshare", "--user", "--map-root-user", "--pid", "--fork", "--kill-child", "--mount-proc", "--net")
FONTS = "fonts"
LAST_WORDS = 400  # characters of a failed diagnosis' error that are kept
PROTOCOL = (
    "own process group, working folder and environment; Python audit events refuse what is outside the working folder"
)


@dataclass(frozen=True)
class Run:
    """How a diagnosis went; its diagnosis.json lies beside."""

    seconds: float  # from start to end of its process
    code: int  # exit code; -1: stopped after `timeout`
    error: str = ""
    refused: tuple[str, ...] = ()  # what it tried and has no business with


class Children:
    """The processes that are running, so that all can be stopped."""

    def __init__(self) -> None:
        self._lock, self._running, self.stopped = threading.Lock(), set[subprocess.Popen[bytes]](), False

    def add(self, child: "subprocess.Popen[bytes]") -> None:
        """Take note of a process; after `stop` it is stopped at once."""
        with self._lock:
            self._running.add(child)
            if self.stopped:
                end(child)

    def remove(self, child: "subprocess.Popen[bytes]") -> None:
        """Forget a process that has ended."""
        with self._lock:
            self._running.discard(child)

    def stop(self) -> None:
        """Stop every process, and all that will be started."""
        with self._lock:
            self.stopped = True
            for child in self._running:
                end(child)


def end(child: "subprocess.Popen[bytes]") -> None:
    """Kill a process that was started in a group of its own, and its group."""
    with suppress(OSError):
        if os.name == "nt":
            child.kill()
        else:
            os.killpg(child.pid, signal.SIGKILL)


@cache
def namespaces() -> tuple[str, ...]:
    """Return what to put before a command so that it sees no other process and no network, if the system can."""
    if shutil.which(NAMESPACES[0]) is None:
        return ()
    done = subprocess.run([*NAMESPACES, "true"], capture_output=True, check=False)
    return NAMESPACES if done.returncode == 0 else ()


def environment(room: Path) -> dict[str, str]:
    """Return the environment of a diagnosis: nothing of ours, one thread of linear algebra, a home of its own."""
    kept = {key: os.environ[key] for key in ("SYSTEMROOT", "SYSTEMDRIVE") if key in os.environ}
    path = os.pathsep.join((str(Path(sys.executable).parent), os.defpath))
    own = {"HOME": str(room), "TMPDIR": str(room), "PATH": path, "LANG": "C.UTF-8"}
    graphics = {
        "MPLBACKEND": "Agg",
        "MPLCONFIGDIR": str(room / FONTS),
        "MUJOCO_GL": "disable",
    }  # no GLFW: it starts processes
    return kept | own | graphics | dict.fromkeys(THREADS, "1")


@cache
def _font_lists() -> tuple[Path, ...]:
    """Return matplotlib's lists of fonts: without one every diagnosis would spend seconds on its own."""
    try:
        from matplotlib import font_manager, get_cachedir
    except ImportError:
        return ()
    font_manager.findfont("DejaVu Sans")
    return tuple(Path(get_cachedir()).glob("fontlist-*.json"))


def words(command: str, room: Path, left_out: str = "-") -> list[str]:
    """Return the command line of a diagnosis; Python programs come under `guard`.

    command: words with {recording} and {out}. The first is `imubench`, a .py file, or any other program.
    """
    first, *rest = shlex.split(command)
    if not {"{recording}", "{out}"} <= set(rest):
        raise InputError(f"diagnosis '{command}': expected the words {{recording}} and {{out}}")
    rest = [word.format(recording="recording", out="diagnosis") for word in rest]
    if first == "imubench" or first.endswith(".py"):
        guard = [sys.executable, "-I", "-B", "-m", "imubench.trials.guard", str(room), left_out]
        return [*namespaces(), *guard, first if first == "imubench" else str(room / "program.py"), *rest]
    return [*namespaces(), first, *rest]


def rooms(kept: Path) -> str:
    """Return how the names of working folders begin for the answers kept in one place: by them they are found again."""
    home = kept.resolve().parent
    return f"imubench-{hashlib.sha256(str(home).encode()).hexdigest()[:12]}-"


def remove_rooms(kept: Path) -> None:
    """Remove the working folders that a run which was killed left; `kept` is any case's, and no other run has it."""
    for left in Path(tempfile.gettempdir()).glob(f"{rooms(kept)}*"):
        shutil.rmtree(left, ignore_errors=True)


def diagnosed(
    recording: Path, kept: Path, command: str, timeout: float, children: Children, left_out: str = "-"
) -> Run:
    """Run a diagnosis on a copy of a recording in a new working folder; put its answer and how it went into `kept`."""
    program = shlex.split(command)[0]
    with tempfile.TemporaryDirectory(prefix=rooms(kept)) as temporary:
        room = Path(temporary).resolve()
        shutil.copytree(recording, room / "recording")
        for file in (room / "recording").rglob("*"):
            os.utime(file, (0, 0))  # when it was written tells nothing
        if program.endswith(".py"):
            shutil.copyfile(program, room / "program.py")
        (room / FONTS).mkdir()
        for fonts in _font_lists():
            shutil.copyfile(fonts, room / FONTS / fonts.name)
        output, begin = room / "output.txt", perf_counter()
        with output.open("wb") as stream:
            child = subprocess.Popen(
                words(command, room, left_out),
                cwd=room,
                env=environment(room),
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                start_new_session=os.name != "nt",
                close_fds=True,
                preexec_fn=die_with_parent(),  # on Linux: it does not outlive us, however we end
            )
            children.add(child)
            try:
                code = child.wait(timeout)
            except subprocess.TimeoutExpired:
                end(child)
                child.wait()
                code = -1
            finally:
                children.remove(child)
        seconds = perf_counter() - begin
        note, answer = room / NOTE, room / "diagnosis" / "diagnosis.json"
        refused = tuple(note.read_text(encoding="utf-8").splitlines()) if note.is_file() else ()
        said = output.read_text(encoding="utf-8", errors="replace")[-LAST_WORDS:].strip()
        error = "" if code == 0 else f"stopped after {timeout:g} s" if code == -1 else said
        run = Run(round(seconds, 2), code, error, refused)
        if not children.stopped:
            kept.mkdir(parents=True, exist_ok=True)
            (kept / "diagnosis.json").unlink(missing_ok=True)  # of a run that was killed just here
            if answer.is_file():
                shutil.copyfile(answer, kept / "diagnosis.json")
            keep_model(answer.parent / MODEL, kept / MODEL)
            with atomic_file(kept / "run.json") as partial:  # last: it says the case is done
                partial.write_text(json.dumps(asdict(run)), encoding="utf-8")
    return run


def keep_model(written: Path, kept: Path) -> None:
    """Copy the plain files of a model that a diagnosis wrote; a link would lead out of its working folder."""
    shutil.rmtree(kept, ignore_errors=True)
    if not written.is_dir() or written.is_symlink():
        return
    kept.mkdir()
    for file in written.iterdir():
        if file.is_file() and not file.is_symlink():
            shutil.copyfile(file, kept / file.name)


def finished(kept: Path) -> Run | None:
    """Return how a diagnosis of an earlier run went, None where there is none that ended."""
    try:
        content = load_table(kept / "run.json")
        return Run(
            float(content["seconds"]), int(content["code"]), str(content["error"]), tuple(map(str, content["refused"]))
        )
    except (ValueError, KeyError, TypeError):  # an InputError is a ValueError
        return None
