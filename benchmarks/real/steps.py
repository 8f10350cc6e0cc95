"""One case from its recording to what a diagnosis and the estimators say, each in a process of its own, kept on disk.

A case's folder: recording/ (format 1), known.json, diagnosis/, axes-raw.json, axes-with.json, and for every process
NAME.step.json with its exit code, processor time and largest memory, written last. What is there is not done again.
"""

import inspect
import os
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.real.axes import RAW
from benchmarks.real.cases import Case
from imubench.answers import write_json
from imubench.arrays import Array
from imubench.atomic import atomic_file
from imubench.commands.diagnose import diagnose_command
from imubench.diagnosis.result_file import FILE_NAME
from imubench.diagnosis.solve.subset import cut
from imubench.errors import InputError
from imubench.format1 import write_recording
from imubench.inputs.json import load_table
from imubench.recording import Recording
from imubench.trials.blind import Children, end
from imubench.workers import THREADS, die_with_parent

ROOT = Path(__file__).resolve().parents[2]
NOT_RUN = "not run yet"
REPORT = 120.0  # s of processor time beyond the limit that writing the report, the model and the log may take
ESTIMATING = 300.0  # s of processor time for three estimators, and the fit that takes out what was found
HUNG = 10.0  # times its processor time that a process may last by the clock, however busy the machine
WORDS = 400  # characters of a failed process' output that are kept


@dataclass(frozen=True)
class Step:
    """How a process went."""

    code: int  # exit code; negative: killed by that signal, SIGXCPU where its processor time was spent
    seconds: float  # of processor time
    memory: float  # GB, the largest
    limit: float  # s of processor time that it was given
    commit: str  # that was checked out
    error: str = ""

    @property
    def failed(self) -> str:
        """Why there is no answer; empty where there is one."""
        return "" if self.code == 0 else self.error or f"ended with {self.code}"


@dataclass(frozen=True)
class Answer:
    """Where a case's answers lie, and how the processes went."""

    case: Case
    folder: Path
    diagnosing: Step | None  # None: it was not asked
    why_not: str = ""

    @property
    def diagnosed(self) -> bool:
        return self.diagnosing is not None and (self.folder / "diagnosis" / FILE_NAME).is_file()

    @property
    def axes(self) -> Array | None:
        """The hinge axes (2, 3) that are known of the case's IMUs."""
        known = load_table(self.folder / "known.json")["axes"]
        return None if known is None else np.array(known)

    def estimates(self, which: str) -> dict[str, Any]:
        """Return what estimators say of the recording, `raw` or `with` the diagnosis; {} where they were not asked.

        What the diagnosis found cannot be taken out: "refused" says why.
        """
        file, step = self.folder / f"axes-{which}.json", _finished(self.folder / f"axes-{which}.step.json")
        if file.is_file():
            return load_table(file)
        return {"refused": step.failed} if which == "with" and step is not None else {}


def knows_baselines() -> bool:
    """Return whether `imubench diagnose` takes a baseline."""
    return "baseline" in inspect.signature(diagnose_command).parameters


@cache
def commit() -> str:
    """Return the commit that is checked out, and whether files differ from it."""

    def git(*words: str) -> str:
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()

    changed = git("status", "--porcelain", "--untracked-files=no")
    return (git("rev-parse", "--short", "HEAD") or "unknown") + (" with changes" if changed else "")


def kept(case: Case, out: Path) -> Answer:
    """Return what an earlier run has of a case."""
    folder = out / case.name
    return Answer(case, folder, _finished(folder / "diagnose.step.json"), NOT_RUN)


def answered(case: Case, out: Path, limit: float, children: Children) -> Answer:
    """Return a case's answer, after doing what an earlier run has not."""
    folder = out / case.name
    if case.baseline and not knows_baselines():
        return Answer(case, folder, None, "imubench diagnose takes no --baseline")
    if case.baseline and not (out / case.baseline / "diagnosis" / FILE_NAME).is_file():
        return Answer(case, folder, None, f"no diagnosis of {case.baseline}")
    try:
        hinge = _recorded(case, folder)
    except InputError as error:  # one recording that cannot be converted does not stop the others
        return Answer(case, folder, None, f"not converted: {error}")
    words = ["diagnose", folder / "recording", "--out", folder / "diagnosis", "--time-limit", f"{limit:g}"]
    if case.baseline:
        words += ["--baseline", out / case.baseline / "diagnosis"]
    step = _done("diagnose", ["-m", "imubench", *map(str, words)], folder, limit, REPORT, children)
    answer = Answer(case, folder, step)
    if hinge:
        _axes(folder, "raw", RAW, children)
        if answer.diagnosed:
            _axes(folder, "with", str(folder / "diagnosis"), children)
    return answer


def _axes(folder: Path, which: str, told: str, children: Children) -> None:
    words = ["-m", "benchmarks.real.axes", str(folder / "recording"), told, str(folder / f"axes-{which}.json")]
    _done(f"axes-{which}", words, folder, ESTIMATING, 0.0, children)


def _recorded(case: Case, folder: Path) -> bool:
    """Write a case's recording and what is known of it, and return whether it is a hinge with two IMUs."""
    known = folder / "known.json"
    if not known.is_file():
        loaded = case.source.load()
        recording = stretch(loaded.recording, case.start, case.end)
        write_recording(recording, folder / "recording", loaded.reference)
        hinge = recording.tree.hinge is not None and len(recording.imus) == 2
        axes = None if loaded.axes is None else loaded.axes.tolist()
        _write(known, {"hinge": hinge, "axes": axes, "seconds": case.end - case.start})
    return bool(load_table(known)["hinge"])


def stretch(recording: Recording, start: float, end: float) -> Recording:
    """Return the samples of a recording between two times in s since its first sample."""
    first = min(float(time[0]) for time in (*(i.time for i in recording.imus), *(e.time for e in recording.encoders)))
    return cut(recording, first + start, first + end)


def _done(name: str, words: Sequence[str], folder: Path, limit: float, more: float, children: Children) -> Step:
    """Run Python with some words, within `limit` and `more` s of processor time; what is finished stays."""
    note, output = folder / f"{name}.step.json", folder / f"{name}.txt"
    earlier = _finished(note)
    if earlier is not None:
        return earlier
    if children.stopped:
        return Step(-signal.SIGKILL, 0.0, 0.0, limit, commit(), "interrupted")
    with output.open("wb") as stream:
        child = subprocess.Popen(
            [sys.executable, *words],
            cwd=ROOT,
            env=os.environ | dict.fromkeys(THREADS, "1") | {"MPLBACKEND": "Agg"},
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            preexec_fn=_bounded(limit + more),
        )
        children.add(child)
        hung = threading.Timer(HUNG * (limit + more), end, [child])
        hung.start()
        try:
            _, status, usage = os.wait4(child.pid, 0)
        finally:
            hung.cancel()
            children.remove(child)
    child.returncode = os.waitstatus_to_exitcode(status)
    said = output.read_text(encoding="utf-8", errors="replace").strip()[-WORDS:]
    step = Step(
        child.returncode,
        round(usage.ru_utime + usage.ru_stime, 2),
        round(usage.ru_maxrss / 1e6, 3),  # kB on Linux
        limit,
        commit(),
        said if child.returncode else "",
    )
    if not children.stopped:
        _write(note, asdict(step))
    return step


def _bounded(limit: float) -> Callable[[], None]:
    """Return what bounds a process' own processor time in s, and ends it with this one."""
    follow, most = die_with_parent(), int(np.ceil(limit))

    def bind() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (most, most))
        if follow is not None:
            follow()

    return bind


def _finished(note: Path) -> Step | None:
    return Step(**load_table(note)) if note.is_file() else None


def _write(file: Path, content: object) -> None:
    with atomic_file(file) as partial:
        write_json(partial, content)
