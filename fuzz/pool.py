"""Workers watched from outside: an input that hangs, grows or crashes its process ends that process, and counts."""

import multiprocessing
import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import partial
from multiprocessing.connection import wait
from pathlib import Path
from time import monotonic

from fuzz.verdict import Outcome
from fuzz.worker import ENVIRONMENT, Limits, Task, work
from imubench.workers import environment

MUTATING = 4 << 30  # bytes that a process may have before it reads
STARTING = 60.0  # s of processor time for its imports, its valid inputs and a mutation
LOOK = 0.02  # s between two looks at a worker
RECYCLED = 3_000  # inputs after which a process makes room for a new one
PAGE = os.sysconf("SC_PAGE_SIZE")
TICKS = os.sysconf("SC_CLK_TCK")


class Worker:
    """A process and what is known of its present task."""

    def __init__(self, limits: Limits, readers: str) -> None:
        self.limits = limits
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        with environment(ENVIRONMENT):
            self.process = context.Process(target=work, args=(theirs, limits, readers))
            self.process.start()
        theirs.close()
        self.task: Task | None = None
        self.done = 0
        self._begun(0)

    def _begun(self, size: int) -> None:
        self.size, self.reading = size, size > 0
        self.cpu, self.peak, self.idle = self._cpu(), 0, 0.0
        self._last = monotonic(), self.cpu

    def give(self, task: Task) -> None:
        """Have a task read."""
        self.task, self.done = task, self.done + 1
        self._begun(0)
        self.connection.send(task)

    def heard(self) -> Outcome | None:
        """Return what came of the task, None where it has only begun; a process that is gone has crashed."""
        try:
            kind, value = self.connection.recv()
        except (EOFError, OSError):
            self.process.join(5)
            return self._ended(f"crash: exit code {self.process.exitcode}")
        if kind == "begin":
            self._begun(value)
        return value if kind == "done" else None

    def beyond(self) -> Outcome | None:
        """Return the failure of a task that takes too long or grew too large, after its process was ended."""
        if self.task is None or not self.process.is_alive():
            return None
        self.peak = max(self.peak, self._resident() - self.size)
        if self.peak > self.limits.memory and self.reading:
            return self._ended("memory: over the limit")
        if self.peak > MUTATING:
            return self._ended("memory: over 4 GB")
        if self._cpu() - self.cpu > (self.limits.seconds if self.reading else STARTING):
            return self._ended("hang: it computes beyond the limit")
        if self._waited() > (self.limits.seconds if self.reading else STARTING):
            return self._ended("hang: it waits beyond the limit")
        return None

    def _waited(self) -> float:
        """Return for how many seconds the process has slept, and not computed nor waited for a busy processor."""
        now, cpu = monotonic(), self._cpu()
        if cpu == self._last[1] and self._stat(0) != "R":
            self.idle += now - self._last[0]
        self._last = now, cpu
        return self.idle

    def _ended(self, what: str) -> Outcome:
        seconds = self._cpu() - self.cpu
        self.process.kill()
        self.process.join()
        self.connection.close()
        if not self.reading:
            what = f"mutator: {what}"
        return Outcome("failed", what, "", max(seconds, 0.0), self.peak / 1e6)

    def stop(self) -> None:
        """End the process."""
        with suppress(OSError, ValueError):
            self.connection.send(None)
        self.process.join(2)
        self.process.kill()
        self.process.join()
        self.connection.close()

    def _resident(self) -> int:
        with suppress(OSError, IndexError, ValueError):
            return int(Path(f"/proc/{self.process.pid}/statm").read_text().split()[1]) * PAGE
        return 0

    def _cpu(self) -> float:
        return (int(self._stat(11)) + int(self._stat(12))) / TICKS

    def _stat(self, field: int) -> str:
        """Return a field of the process' line in /proc behind its name: 0 its state, 11 and 12 its time in ticks."""
        with suppress(OSError, IndexError):
            return Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()[field]
        return "0"


class Pool:
    """So many workers; use it as a context. `readers` is the module whose `READERS` the tasks name."""

    def __init__(self, count: int, limits: Limits | None = None, readers: str = "fuzz.readers") -> None:
        self._make = partial(Worker, limits or Limits(), readers)
        self.workers = [self._make() for _ in range(count)]

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, *error: object) -> None:
        for worker in self.workers:
            worker.stop()

    def run(self, tasks: Iterable[Task]) -> Iterator[tuple[Task, Outcome]]:
        """Yield each task with what came of it, in the order in which they end."""
        left = iter(tasks)
        for worker in self.workers:
            self._next(worker, left)
        while busy := {w.connection: w for w in self.workers if w.task is not None}:
            heard = set(wait(list(busy), LOOK))
            for connection, worker in busy.items():
                outcome = worker.heard() if connection in heard else worker.beyond()
                if outcome is None or worker.task is None:
                    continue
                task, worker.task = worker.task, None
                if not worker.process.is_alive():
                    worker = self._renewed(worker)
                elif worker.done >= RECYCLED:
                    worker.stop()
                    worker = self._renewed(worker)
                yield task, outcome
                self._next(worker, left)

    def one(self, task: Task) -> Outcome:
        """Return what comes of one task."""
        ((_, outcome),) = self.run([task])
        return outcome

    def _next(self, worker: Worker, left: Iterator[Task]) -> None:
        task = next(left, None)
        if task is not None:
            worker.give(task)

    def _renewed(self, old: Worker) -> Worker:
        new = self._make()
        self.workers[self.workers.index(old)] = new
        return new
