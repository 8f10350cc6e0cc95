"""Run the fuzzer: `python -m fuzz --seconds 180 --seed 7`, or `--inputs 100000 --each 3000`."""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from time import monotonic

from fuzz import inputs
from fuzz.corpus import CORPUS, LARGEST, keep
from fuzz.minimise import minimised
from fuzz.pool import Pool
from fuzz.readers import READERS
from fuzz.table import Failure, Table
from fuzz.worker import Task
from imubench.workers import cores

ENDLESS = 10**9
TOLD = 5_000  # inputs after which progress is told


def main(words: list[str] | None = None) -> int:
    """Read mutated inputs until the time is over or all are read; return 1 where one failed."""
    asked = _parser().parse_args(words)
    names = asked.reader or list(READERS)
    unknown = [name for name in names if name not in READERS]
    if unknown:
        print(f"unknown reader '{unknown[0]}'; known: {', '.join(READERS)}", file=sys.stderr)
        return 2
    each = max(asked.each, -(-asked.inputs // len(names))) or ENDLESS
    if each == ENDLESS and asked.seconds is None:
        asked.seconds = 600.0
    table, start = Table(), monotonic()
    with Pool(asked.workers or cores()) as pool:
        deadline = None if asked.seconds is None else start + asked.seconds
        for task, outcome in pool.run(_tasks(names, asked, each, deadline)):
            if table.add(task, outcome):
                print(f"failed: {task.reader} --first {task.index}: {outcome.what}", file=sys.stderr, flush=True)
            if (done := table.inputs) % TOLD == 0:
                print(f"{done:,} inputs, {monotonic() - start:.0f} s", file=sys.stderr, flush=True)
        print(table.markdown())
        print(f"\n{table.inputs:,} inputs of {len(table.rows)} readers, seed {asked.seed}, {monotonic() - start:.0f} s")
        kept: set[str] = set()
        for failure in table.failures.values():  # one of each kind is kept: readers share code
            what = failure.outcome.what
            _tell(failure, pool, None if asked.keep_nothing or what in kept else asked.corpus)
            kept.add(what)
    return int(bool(table.failures))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "python -m fuzz", description="Mutated inputs for every reader that a command has."
    )
    parser.add_argument("--inputs", type=int, default=0, help="how many, spread over the readers")
    parser.add_argument("--each", type=int, default=0, help="at least so many of each reader")
    parser.add_argument("--seconds", type=float, help="until so much time is over; 600 where no number is given")
    parser.add_argument("--seed", type=int, default=0, help="the same seed gives the same inputs")
    parser.add_argument("--first", type=int, default=0, help="begin with this input of each reader")
    parser.add_argument("--reader", action="append", help="only this reader; may come more than once")
    parser.add_argument("--workers", type=int, help="processes; none: one a core")
    parser.add_argument("--corpus", type=Path, default=CORPUS, help="where minimised failures are kept")
    parser.add_argument("--keep-nothing", action="store_true", help="tell failures, and neither minimise nor keep them")
    parser.add_argument("--no-commands", action="store_true", help="readers alone, no whole commands")
    return parser


def _tasks(names: list[str], asked: argparse.Namespace, each: int, deadline: float | None) -> Iterator[Task]:
    """Yield inputs, the readers in turn, so that all have had as many whenever the time is over."""
    for index in range(asked.first, asked.first + each):
        for name in names:
            if deadline is not None and monotonic() > deadline:
                return
            yield Task(name, asked.seed, index, command=not asked.no_commands and index % READERS[name].every == 0)


def _tell(failure: Failure, pool: Pool, corpus: Path | None) -> None:
    task, outcome = failure.task, failure.outcome
    again = f"python -m fuzz --reader {task.reader} --seed {task.seed} --first {task.index} --each 1"
    print(f"\n{task.reader}: {outcome.what}; {failure.count} inputs\n  {again}")
    if corpus is not None and not outcome.what.startswith("mutator"):
        content = minimised(pool, task, inputs.content(READERS[task.reader], task.seed, task.index), outcome.what)
        small = len(content) <= LARGEST
        where = keep(corpus, task.reader, outcome.what, content) if small else "too large to be kept"
        print(f"  {len(content)} bytes: {where}")
    print("  " + outcome.said.strip().replace("\n", "\n  "), flush=True)


if __name__ == "__main__":
    sys.exit(main())
