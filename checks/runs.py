"""The runs that claims are decided by: played and estimated on all cores, taken in order, kept when interrupted.

A run follows from its estimator, its scenario and its number. Runs are taken in the order of their numbers, so that a
decision is the same whatever the number of processes; those ahead of it are dropped.
"""

import json
import time
from collections.abc import Generator, Iterator, Mapping
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from imubench.atomic import atomic_file, remove_partial_files
from imubench.attempt import Failed, attempted, own_apart
from imubench.checks.figures import figures_of
from imubench.checks.scenario import Scenario
from imubench.checks.versions import ESTIMATING, SIMULATING, code_key
from imubench.dataset.ranges import is_number
from imubench.errors import InputError
from imubench.inputs.files import real, what_is
from imubench.inputs.json import load_table
from imubench.inputs.limits import JSON_BYTES
from imubench.leftovers import undone
from imubench.plugin_versions import estimator_version
from imubench.plugins import find_estimator, is_outside
from imubench.score import score
from imubench.workers import Pool, process_pool

AHEAD = 2
"""Runs that each process has waiting, so that none waits for the next."""
EVERY = 5.0
"""Seconds between two times that what is finished is written: as much is lost when a check is killed."""


@dataclass(frozen=True)
class Subject:
    """What is run: an estimator on a scenario."""

    estimator: str
    scenario: Scenario
    time_limit: float  # s, of one estimate

    @property
    def key(self) -> str:
        """What changes with everything that a run depends on, but for its number."""
        version = estimator_version(find_estimator(self.estimator))
        parts = (version, self.scenario.key, code_key(SIMULATING), code_key(ESTIMATING))
        return sha256(f"{self.estimator} {self.time_limit} {parts}".encode()).hexdigest()[:24]


@dataclass(frozen=True)
class Outcome:
    """One run: the figures of its estimate, or why there is none."""

    figures: Mapping[str, float]  # rad or m
    why: str = ""  # one line


def played(subject: Subject, number: int) -> Outcome:
    """Return run `number`: simulated, estimated, scored; an estimator that fails is an outcome, and no error.

    Raises:
        InputError: the scenario draws what cannot be played, or has no truth that the estimate can be held against.
    """
    recording, truth = subject.scenario.recording(number)
    estimator = find_estimator(subject.estimator)
    limit = subject.time_limit if is_outside(estimator) else None
    answer = attempted(estimator, recording, limit, own_apart())
    if isinstance(answer, Failed):
        return Outcome({}, f"{answer.status}: {answer.why}")
    return Outcome(figures_of(score(answer, truth)))


class Runs:
    """Runs of many subjects by number, in this process or in others."""

    def __init__(self, pool: Pool | None, workers: int, store: Path | None) -> None:
        self._pool, self._workers, self._store = pool, workers, store
        self._done: dict[Subject, dict[int, Outcome]] = {}
        self._paths: dict[Subject, Path | None] = {}
        self._saved = time.monotonic()

    def of(self, subject: Subject, first: int) -> Generator[Outcome, None, None]:
        """Yield the runs of a subject from number `first` on, without end; end it with `close`."""
        if subject not in self._done:
            self._paths[subject] = None if self._store is None else self._store / f"{subject.key}.json"
            self._done[subject] = stored_runs(self._paths[subject])
            _tidy(self._paths[subject])
        done = self._done[subject]
        ahead: dict[int, Future[Outcome]] = {}
        number = first
        try:
            while True:
                self._submit(subject, number, done, ahead)
                if number not in done:
                    done[number] = ahead.pop(number).result() if number in ahead else played(subject, number)
                self._save(subject, EVERY)
                yield done[number]
                number += 1
        finally:
            for future in ahead.values():
                future.cancel()
            self._save(subject, 0.0)

    def forget(self) -> None:
        """Remove what was kept of these subjects; others may still be gone on with."""
        for path in self._paths.values():
            if path is not None:
                path.unlink(missing_ok=True)
                with suppress(OSError):  # others are left
                    path.parent.rmdir()

    def _submit(self, subject: Subject, number: int, done: dict[int, Outcome], ahead: dict[int, Any]) -> None:
        if self._pool is None:
            return
        for n in range(number, number + AHEAD * self._workers):
            if n not in done and n not in ahead:
                ahead[n] = self._pool.submit(played, subject, n)

    def _save(self, subject: Subject, every: float) -> None:
        path = self._paths[subject]
        if path is None or time.monotonic() - self._saved < every:
            return
        content = {str(n): {"figures": dict(o.figures), "why": o.why} for n, o in self._done[subject].items()}
        with atomic_file(path) as partial:
            partial.write_text(json.dumps(content), encoding="utf-8")
        self._saved = time.monotonic()


def _tidy(path: Path | None) -> None:
    """Remove what a check that was killed was just writing."""
    if path is not None and path.parent.is_dir():
        remove_partial_files(path)


def stored_runs(path: Path | None) -> dict[int, Outcome]:
    """Return the runs in a file; none where it is missing or damaged, for then they are run again."""
    if path is None or what_is(path) != "a file":
        return {}
    try:
        return {int(n): _outcome(entry) for n, entry in load_table(path, JSON_BYTES).items()}
    except (InputError, ValueError, TypeError):
        return {}


def _outcome(entry: object) -> Outcome:
    """Return a stored outcome; ValueError where it is none."""
    figures = entry.get("figures") if isinstance(entry, dict) else None
    if not isinstance(entry, dict) or not isinstance(figures, dict) or not isinstance(entry.get("why"), str):
        raise ValueError("no outcome")
    if not all(is_number(value) and value >= 0 for value in figures.values()):
        raise ValueError("no figures")
    return Outcome(figures, entry["why"])


@contextmanager
def running(workers: int, out: Path | None) -> Iterator[Runs]:
    """Hand out runs by so many processes, or in this one for 1; what is finished is kept beside `out` until all is.

    Args:
        workers: how many.
        out: the folder of the results; None: nothing is kept.
    """
    store = None if out is None else real(out).parent / f".{real(out).name}.runs"
    with ExitStack() as stack:
        stack.enter_context(undone(own_apart().end))
        pool = stack.enter_context(process_pool(workers)) if workers > 1 else None
        runs = Runs(pool, workers, store)
        yield runs
    runs.forget()
