"""A write of a command fails: what it says then, what it leaves, and that the same command comes to its end later.

python -m tests.faults.injection [COUNT] [NAME ...]      so many trials of each named command, or of all
"""

import errno
import json
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import sysconfig
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.faults.commands import COMMANDS, Command, given
from tests.faults.content import content, without_stages

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
LIMIT = 240.0  # s for a command; the longest takes 10 s on an idle machine
LONGEST_LINE = 300 + len("imubench: ")
MOST = 60  # calls of a command that each get every kind of fault; of more, a sample
HIDDEN = re.compile(r"(^|/)\.[^/]*(\.partial|\.old|\.lock)(\.|/|$)|\.generate/lock$")
"""Names that count for nothing, of what a killed run may leave and the next one removes."""

FREE = re.compile(r"\.[0-9a-f]{8}\.")  # what names of partial files are made of
IMPORTED = (
    "matplotlib.backends.backend_agg", "pyarrow.csv", "scipy.io", "imubench.commands.work.generate", "imubench.convert",
    "imubench.dataset.exports", "imubench.correction.corrected", "imubench.diagnosis.pipeline",
    "imubench.diagnosis.report", "imubench.estimators", "imubench.listing", "imubench.reproduce.reproduce",
    "imubench.scenarios", "imubench.trials.prove", "imubench.trials.sealed",
)  # fmt: skip


@dataclass(frozen=True)
class Fault:
    """What happens to calls that write."""

    name: str
    number: int  # errno; -1: the write is cut short to a byte; -100 - SIGNAL: the process gets the signal before it
    more: bool = False  # every later call fails as well
    kinds: tuple[str, ...] = ()  # of calls it may happen to; none: all
    code: int = 2  # of the exit, unless the command comes to its end; 0: it must
    line: str = "imubench: "  # how the one line begins


FAULTS = (
    Fault("full disk", errno.ENOSPC, more=True),
    Fault("ENOSPC once", errno.ENOSPC),
    Fault("EIO once", errno.EIO),
    Fault("EIO for good", errno.EIO, more=True),
    Fault("EINTR", errno.EINTR, kinds=("open", "write", "fsync", "ftruncate"), code=0),
    Fault("short write", -1, kinds=("write",), code=0),
    Fault("SIGTERM", -100 - signal.SIGTERM, code=143, line="imubench: terminated; "),
    Fault("SIGINT", -100 - signal.SIGINT, code=130, line="imubench: interrupted; "),
    Fault("SIGKILL", -100 - signal.SIGKILL, code=-signal.SIGKILL, line=""),
)


@dataclass(frozen=True)
class Ended:
    """How a command line ended."""

    code: int
    said: str
    errors: str
    seconds: float
    calls: tuple[str, ...]  # that write, KIND PATH each, of all its processes
    late: bool
    running: tuple[int, ...]  # processes that outlived it


@dataclass
class Trial:
    """One fault in one command, and what was wrong with how it was met."""

    command: str
    fault: str
    at: int
    call: str
    code: int = 0  # of the exit
    wrong: list[str] = field(default_factory=list)


def build(folder: Path) -> Path:
    """Compile the shim and return it."""
    made = folder / "shim.so"
    compiler = shutil.which("cc")
    assert compiler is not None
    command = [compiler, "-O1", "-shared", "-fPIC", "-o", str(made), str(HERE / "shim.c"), "-ldl"]
    subprocess.run(command, check=True, capture_output=True)
    return made


def environment_of_a_command() -> dict[str, str]:
    """Return our environment, in which these modules are found, with one thread of linear algebra."""
    path = os.pathsep.join(filter(None, (os.environ.get("PYTHONPATH"), str(ROOT))))
    return {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": path}


def why_not() -> str:
    """Return why faults cannot be injected here; "" where they can."""
    if not sys.platform.startswith("linux") or sysconfig.get_config_var("Py_DEBUG"):
        return "needs Linux' LD_PRELOAD and /proc"
    return "" if shutil.which("cc") else "needs a C compiler `cc`"


class Warm:
    """A process that runs command lines, each in a child of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        environment = {**environment_of_a_command(), "LD_PRELOAD": str(build(folder))}
        command = [sys.executable, str(HERE / "warm.py"), *IMPORTED]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )
        assert self._answer() == "ready"

    def close(self) -> None:
        """End the process."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait(10)

    def _answer(self) -> Any:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"the warm process ended: {self.process.wait()}")
        return json.loads(line)

    def run(self, line: list[str], work: Path, prelude: str = "", fault: Fault | None = None, at: int = 0) -> Ended:
        """Run a command line in the folder `work`, with `work`-tmp for temporary files."""
        temporary, count, log = (work.with_name(f"{work.name}-{what}") for what in ("tmp", "count", "log"))
        temporary.mkdir(exist_ok=True)
        count.write_bytes(struct.pack("q", 0))
        said, errors = work.with_name("said"), work.with_name("errors")
        for file in (log, said, errors):
            file.unlink(missing_ok=True)
        environment = {
            "TMPDIR": str(temporary),
            "FAULTS_BELOW": f"{work}:{temporary}",
            "FAULTS_COUNT": str(count),
            "FAULTS_LOG": str(log),
            "FAULTS_AT": str(at),
            "FAULTS_ERRNO": str(fault.number if fault else 0),
            "FAULTS_MORE": str(int(bool(fault and fault.more))),
        }
        asked = {"line": line, "folder": str(work), "said": str(said), "errors": str(errors), "limit": LIMIT}
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps({**asked, "environment": environment, "prelude": prelude}) + "\n")
        self.process.stdin.flush()
        answer = self._answer()
        calls = tuple(log.read_text().splitlines()) if log.exists() else ()
        running = outlived(answer["pid"])
        texts = (said.read_text(errors="replace"), without_stages(errors.read_text(errors="replace")))
        return Ended(answer["code"], *texts, answer["seconds"], calls, answer["late"], running)


def outlived(session: int, patience: float = 5.0) -> tuple[int, ...]:
    """Return the processes of a session that are still there after `patience` s."""
    end = time.monotonic() + patience
    while (found := in_session(session)) and time.monotonic() < end:
        time.sleep(0.05)
    return found


def in_session(session: int) -> tuple[int, ...]:
    """Return the processes of a session but those that have ended and were not waited for."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, _, _, of = (entry / "stat").read_text().rpartition(")")[2].split()[:4]
            except (OSError, ValueError):
                continue
            if int(of) == session and state != "Z":
                found.append(int(entry.name))
    return tuple(found)


class Injection:
    """A command whose writes fail one after the other."""

    def __init__(self, command: Command, warm: Warm, made: Path, older: Path, home: Path) -> None:
        """`made` is what `given` made, `older` a finished folder of another command."""
        self.command, self.warm, self.made, self.older, self.home = command, warm, made, older, home
        self.line = command.line(made)
        home.mkdir()
        work, self.before = self._set_up("whole", replacing=False)
        self.first = warm.run(self.line, work, command.prelude)
        if self.first.code not in (0, 1) or self.first.errors:
            raise RuntimeError(f"{command.name}: {self.first.code} {self.first.errors}")
        self.code = self.first.code
        self.whole = self._written(work)
        self.all = content(work)

    def _set_up(self, name: str, replacing: bool) -> tuple[Path, dict[str, object]]:
        """Make the folder that the command is given in; return it and what is in it."""
        work = self.home / name
        work.mkdir()
        for folder in self.command.copied:
            shutil.copytree(self.made / folder, work / folder)
        if replacing:
            shutil.copytree(self.older, work / "out")
        return work, content(work)

    def _written(self, work: Path) -> dict[str, object]:
        found: dict[str, object] = {}
        for name in self.command.writes:
            path = work / name
            if path.exists():
                found |= {f"{name}/{inner}": value for inner, value in content(path).items()}
        return found

    def places(self) -> list[int]:
        """Return the numbers of the calls that are made to fail: all, or one of each kind and file, and some more."""
        calls = [FREE.sub(".", call) for call in self.first.calls]
        if len(calls) <= MOST:
            return list(range(1, len(calls) + 1))
        firsts = {call: number for number, call in reversed(list(enumerate(calls, 1)))}
        others = sorted(set(range(1, len(calls) + 1)) - set(firsts.values()))
        more = random.Random(0).sample(others, min(len(others), max(0, MOST - len(firsts))))
        return sorted({*firsts.values(), *more})

    def plan(self) -> list[tuple[int, Fault]]:
        """Return every fault at every place that it may happen at."""
        return [(n, f) for n in self.places() for f in FAULTS if not f.kinds or self._kind(n) in f.kinds]

    def sample(self, count: int) -> list[tuple[int, Fault]]:
        """Return so many of the plan: every fault as often as any other, and every kind of call as often as can be."""
        left = self.plan()
        random.Random(1).shuffle(left)
        faults: Counter[str] = Counter()
        kinds: Counter[str] = Counter()
        chosen = []
        while left and len(chosen) < count:
            number, fault = min(left, key=lambda one: (faults[one[1].name], kinds[self._kind(one[0])]))
            left.remove((number, fault))
            chosen.append((number, fault))
            faults[fault.name] += 1
            kinds[self._kind(number)] += 1
        return chosen

    def _kind(self, number: int) -> str:
        return self.first.calls[number - 1].split()[0]

    def trial(self, at: int, fault: Fault, again: bool = True) -> Trial:
        """Have a call fail, look at what is left, and give the command once more."""
        call = FREE.sub(".", self.first.calls[at - 1]).replace(str(self.home / "whole"), "")
        done = Trial(self.command.name, fault.name, at, call)
        replacing = self.command.replaces and bool(at % 2)
        work, before = self._set_up("work", replacing)
        ended = self.warm.run(self.line, work, self.command.prelude, fault, at)
        done.code = ended.code
        done.wrong += self._said(ended, fault)
        after = content(work)
        if ended.code == self.code:
            if self._written(work) != self.whole or set(after) - set(before) - set(self.all):
                done.wrong.append(f"exit code {ended.code}, and not the output: {self._difference(after)}")
        else:
            odd = [name for name in after if before.get(name) != after[name] and not self._kept(name)]
            odd += [name for name in before if name not in after]
            if ended.code == -signal.SIGKILL:  # what is hidden is removed by the next run
                odd = [name for name in odd if not HIDDEN.search(name)]
            if odd and self._written(work) != self.whole:
                done.wrong.append(f"left behind or changed: {sorted(odd)[:4]}")
        left = sorted(p.name for p in work.with_name("work-tmp").rglob("*"))
        if left and ended.code != -signal.SIGKILL:
            done.wrong.append(f"left in the temporary folder: {left[:4]}")
        if again and ended.code != self.code:
            second = self.warm.run(self.line, work, self.command.prelude)
            if second.code != self.code or self._written(work) != self.whole:
                done.wrong.append(f"again: {second.code}, {second.errors.strip()} {self._difference(content(work))}")
            elif odd := set(content(work)) - set(self.all):
                done.wrong.append(f"again: left behind {sorted(odd)[:4]}")
            if left := sorted(p.name for p in work.with_name("work-tmp").rglob("*")):
                done.wrong.append(f"again: left in the temporary folder: {left[:4]}")
        for path in (work, work.with_name("work-tmp")):
            shutil.rmtree(path)
        return done

    def _kept(self, name: str) -> bool:
        return any(name == kept or name.startswith(f"{kept}/") for kept in self.command.kept) and ".partial" not in name

    def _said(self, ended: Ended, fault: Fault) -> Iterator[str]:
        lines = ended.errors.splitlines()
        if ended.late:
            yield f"not ended after {LIMIT:g} s"
        if ended.running:
            yield f"{len(ended.running)} processes outlived it"
        if ended.code == self.code:
            if ended.errors:
                yield f"exit code {ended.code}, and it said: {ended.errors[:300]}"
        elif not fault.code:
            yield f"{fault.name} was not invisible: {ended.code} {ended.errors[-300:]}"
        elif ended.code != fault.code and not (fault.number <= -100 and ended.code == 2):  # a worker got the signal
            yield f"exit code {ended.code}: {ended.errors[-600:]}"
        elif ended.code == -signal.SIGKILL:
            if ended.errors:
                yield f"said after SIGKILL: {ended.errors[-300:]}"
        elif len(lines) != 1 or len(lines[0]) > LONGEST_LINE or not lines[0].startswith("imubench: "):
            yield f"{len(lines)} lines: {ended.errors[:600]}"
        elif ended.code == fault.code and not lines[0].startswith(fault.line):
            yield f"it said: {lines[0]}"

    def _difference(self, found: dict[str, object]) -> str:
        odd = {name for name in {*found, *self.all} if found.get(name) != self.all.get(name)}
        return f"different: {sorted(odd)[:6]}"


class Injections:
    """Injections into commands by name, in a folder of their own."""

    def __init__(self, home: Path) -> None:
        self.home, self.made, self.warm = home, given(home / "given"), Warm(home)
        (home / "older").mkdir()
        self.warm.run(COMMANDS["list"].line(self.made), home / "older")

    def into(self, name: str) -> Injection:
        """Return a command after its first, undisturbed run."""
        folder = self.home / name.replace(" ", "_")
        return Injection(COMMANDS[name], self.warm, self.made, self.home / "older" / "out", folder)


def main(words: list[str]) -> int:
    """Do so many trials of each of the named commands, of all without a name, and print what was wrong."""
    from tempfile import TemporaryDirectory

    wrong = 0
    most = int(words[0]) if words and words[0].isdigit() else None
    with TemporaryDirectory() as temporary:
        all_of_them = Injections(Path(temporary).resolve())
        for name in words[most is not None :] or COMMANDS:
            begun = time.monotonic()
            one = all_of_them.into(name)
            plan = one.plan() if most is None else one.sample(most)
            print(f"{name}: {len(one.first.calls)} calls, {len(plan)} trials, {one.first.seconds:.1f} s", flush=True)
            for at, fault in plan:
                done = one.trial(at, fault)
                wrong += bool(done.wrong)
                for what in done.wrong:
                    print(f"  {fault.name} at {at} ({done.call}): {what}", flush=True)
            print(f"  {time.monotonic() - begun:.0f} s", flush=True)
        all_of_them.warm.close()
    print(f"{wrong} trials with something wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
