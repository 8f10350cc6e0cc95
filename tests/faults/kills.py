"""A command is killed at a moment by chance: what is left then, and what the same command comes to afterwards."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tests.faults.commands import Command
from tests.faults.content import content, without_stages
from tests.faults.injection import HIDDEN, environment_of_a_command

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
AFTER = 5.0  # s after which nothing may be running any more
LIMIT = 600.0  # s for an undisturbed command; the longest takes 30 s on an idle machine
PYTHONS_OWN = "Fatal Python error: init_import_site"  # what the interpreter says, interrupted before it is ready
EARLY = {signal.SIGTERM: -signal.SIGTERM, signal.SIGINT: -signal.SIGINT}  # exit codes before our code has run


@dataclass
class Killed:
    """One kill, and what was wrong with what followed."""

    command: str
    signal: str
    moment: float  # s after the start
    phase: str  # where it was: "start-up", "at work", "ended"
    wrong: list[str] = field(default_factory=list)
    again: bool = False  # whether the command was given again: not where nothing at all was left


class Kills:
    """A command that is killed again and again."""

    def __init__(self, command: Command, given: Path, home: Path) -> None:
        self.command, self.home, self.line = command, home, command.line(given)
        home.mkdir(parents=True)
        work, self.before = self._set_up("whole")
        begun = time.monotonic()
        done = self.start(work)
        errors = without_stages(done.communicate(timeout=LIMIT)[1].decode(errors="replace"))
        self.seconds, self.code = time.monotonic() - begun, done.returncode
        if self.code not in (0, 1) or errors:
            raise RuntimeError(f"{command.name}: {self.code} {errors}")
        self.whole = content(work)

    def _set_up(self, name: str) -> tuple[Path, dict[str, object]]:
        work = self.home / name
        for folder in (work, work.with_name(f"{name}-tmp")):
            folder.mkdir()
        return work, content(work)

    def start(self, work: Path) -> "subprocess.Popen[bytes]":
        """Start the command in the folder `work`, with `work`-tmp for temporary files."""
        temporary = str(work.with_name(f"{work.name}-tmp"))
        environment = {**environment_of_a_command(), "TMPDIR": temporary}
        begin = ["-m", "imubench"]
        if self.command.prelude:  # what it imports is not the command's: signals end it as they end any program
            default = "import signal; signal.signal(signal.SIGINT, signal.SIG_DFL)"
            begin = [
                "-c",
                f"{default}; import tests.faults.commands as c; c.tiny(); from imubench.main import main; main()",
            ]
        return subprocess.Popen(
            [sys.executable, *begin, *self.line],
            cwd=work,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=lambda: signal.signal(
                signal.SIGINT, signal.SIG_DFL
            ),  # a shell's jobs in the background ignore it
        )

    def kill(self, number: signal.Signals, moment: float, group: bool) -> Killed:
        """Start the command, signal it or its whole group after `moment` s, and look at what is left."""
        work, _ = self._set_up("work")
        process = self.start(work)
        time.sleep(moment)
        if process.poll() is None:
            (os.killpg if group else os.kill)(process.pid, number)
        done = Killed(self.command.name, number.name, round(moment, 2), "at work")
        try:
            errors = process.communicate(timeout=AFTER + 60)[1].decode(errors="replace")
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            errors = process.communicate()[1].decode(errors="replace")
            done.wrong.append("did not end in 65 s")
        errors = without_stages(errors)
        done.phase = self._phase(process.returncode, number, moment, errors)
        done.wrong += self._ended(process.returncode, errors, number, done.phase)
        if left := running(self.home):
            done.wrong.append(f"running after {AFTER:g} s: {left[:3]}")
        after, temporary = content(work), content(work.with_name("work-tmp"))
        done.wrong += self._left(after, temporary, number, process.returncode)
        if after != self.before or temporary:
            done.again = True
            second = self.start(work)
            errors = without_stages(second.communicate(timeout=LIMIT)[1].decode(errors="replace"))
            if second.returncode != self.code or errors:
                done.wrong.append(f"again: {second.returncode} {errors[:300]}")
            if odd := different(content(work), self.whole):
                done.wrong.append(f"again: different: {odd[:4]}")
            if names := sorted(content(work.with_name("work-tmp"))):
                done.wrong.append(f"again: left in the temporary folder: {names[:4]}")
        for folder in (work, work.with_name("work-tmp")):
            shutil.rmtree(folder)
        return done

    def _phase(self, code: int, number: signal.Signals, moment: float, errors: str) -> str:
        if errors.startswith(PYTHONS_OWN):
            return "start-up"
        if code == self.code:
            return "ended"
        return "start-up" if code == EARLY.get(number) or (code == -signal.SIGKILL and moment < 0.1) else "at work"

    def _ended(self, code: int, errors: str, number: signal.Signals, phase: str) -> list[str]:
        lines = errors.splitlines()
        if number == signal.SIGKILL or phase != "at work":
            fits = code in (self.code, -number) or errors.startswith(PYTHONS_OWN)
            return [] if fits and not (phase == "ended" and errors) else [f"exit code {code}: {errors[-500:]}"]
        word = {signal.SIGTERM: "terminated", signal.SIGINT: "interrupted"}[number]
        if code != 128 + number or len(lines) != 1 or not lines[0].startswith(f"imubench: {word}; "):
            return [f"exit code {code}, {len(lines)} lines: {errors[:300]} ... {errors[-500:]}"]
        return []

    def _left(
        self, after: dict[str, object], temporary: dict[str, object], number: signal.Signals, code: int
    ) -> list[str]:
        wrong = []
        for name in self.command.writes:
            found, asked = (
                {k: v for k, v in c.items() if k == name or k.startswith(f"{name}/")} for c in (after, self.whole)
            )
            if name not in self.command.kept and found and found != asked:
                wrong.append(f"half-written: {different(found, asked)[:4]}")
        if number != signal.SIGKILL:
            hidden = [name for name in after if HIDDEN.search(name)]
            kept = (*self.command.kept, *self.command.writes)
            hidden += [
                n for n in after if not any(n == k or n.startswith(f"{k}/") for k in kept) and n not in self.before
            ]
            if hidden:
                wrong.append(f"left behind: {sorted(hidden)[:4]}")
            if temporary:
                wrong.append(f"left in the temporary folder: {sorted(temporary)[:4]}")
        return wrong


def different(one: dict[str, object], other: dict[str, object]) -> list[str]:
    """Return the names of what is not the same in both."""
    return sorted(name for name in {*one, *other} if one.get(name) != other.get(name))


def running(home: Path) -> list[str]:
    """Return what still runs after `AFTER` s of what was started for `home`: that is its folder, or in its words."""
    end = time.monotonic() + AFTER
    while (found := _running(home)) and time.monotonic() < end:
        time.sleep(0.05)
    return found


def _running(home: Path) -> list[str]:
    text, found = os.fsencode(str(home)), []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit() or int(entry.name) == os.getpid():
            continue
        try:
            words = (entry / "cmdline").read_bytes()
            told = words + (entry / "environ").read_bytes() + os.fsencode((entry / "cwd").readlink())
            if text in told and words:  # one that has ended and was not waited for has no words
                found.append(f"{entry.name} {words.replace(bytes(1), b' ')[:120].decode(errors='replace')}")
        except OSError:  # it has ended, or is another user's
            continue
    return found


def moments(kills: Kills, count: int, number: signal.Signals) -> list[float]:
    """Return when to kill, drawn once and for all by the command's name."""
    rng = random.Random(f"{kills.command.name} {number.name}")
    return sorted(rng.uniform(0.0, kills.seconds) for _ in range(count))


def summary(done: list[Killed]) -> str:
    """Return how many kills met which phase."""
    return ", ".join(f"{count} {phase}" for phase, count in sorted(Counter(k.phase for k in done).items()))
