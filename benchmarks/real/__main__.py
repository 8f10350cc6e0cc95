"""Diagnose every real recording at hand and write the tables: `make real`, or python -m benchmarks.real --help."""

import argparse
import os
import platform
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from datetime import UTC, datetime
from pathlib import Path

from benchmarks.__main__ import processor
from benchmarks.real.cases import Case, cases, chosen
from benchmarks.real.facts import fact_of, facts
from benchmarks.real.repeat import moved, repeated
from benchmarks.real.required import rows
from benchmarks.real.said import read_said
from benchmarks.real.scoring import scored
from benchmarks.real.sources import sources
from benchmarks.real.steps import ROOT, Answer, answered, kept
from benchmarks.real.table import Halves, Line, cases_table, facts_table, halves_table, replaced, rows_table
from imubench.atomic import atomic_file
from imubench.errors import InputError
from imubench.format1 import read
from imubench.lock import locked
from imubench.terminal import Terminal
from imubench.trials.blind import Children
from imubench.workers import cores

LIMIT = 600.0  # s of processor time of a diagnosis: what `imubench diagnose` takes where nobody says
RESULTS, DOCS = ROOT / "benchmarks" / "RESULTS.md", ROOT / "docs" / "real.md"
HEADING = {RESULTS: "## Real recordings", DOCS: "## Results"}
KNOWN = "## What is known"


def main(words: Sequence[str]) -> int:
    """Run what is asked for; return 0, 1 where a requirement is missed, 2 for bad input, 130 after Ctrl-C."""
    asked = _parser().parse_args(words)
    say = Terminal(stderr=True)
    try:
        return _suite(asked, say)
    except InputError as error:
        say.say(str(error))
        return 2
    except KeyboardInterrupt:
        say.say("interrupted; the same command goes on where it was")
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real", description=__doc__)
    parser.add_argument("--list", action="store_true", help="only list the cases, and what is known of each")
    parser.add_argument(
        "--only", action="append", default=[], metavar="PATTERN", help="cases whose names match: 'diodem/*/3-4-foam/*'"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("runs/real"), help="where answers are kept; remove it to begin anew"
    )
    parser.add_argument("--time-limit", type=float, default=LIMIT, metavar="S", help="processor time of a diagnosis")
    parser.add_argument("--workers", type=int, default=cores(), help="cases at a time")
    parser.add_argument("--table", action="store_true", help="run nothing, write the tables of what is there")
    parser.add_argument(
        "--write", action="store_true", help="write RESULTS.md and docs/real.md with --only or --table, too"
    )
    return parser


def _suite(asked: argparse.Namespace, say: Terminal) -> int:
    every = cases(list(sources(data_folder())))
    some = chosen(every, asked.only)
    if not some:
        raise InputError(f"--only: expected a pattern of case names, see --list, got {', '.join(asked.only)}")
    if asked.list:
        print("\n".join(f"{case.name}: {fact_of(case.name).known}" for case in some))
        return 0
    out = asked.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    with locked(out / ".lock", asked.out):
        answers = [kept(c, out) for c in some] if asked.table else run(some, out, asked.time_limit, asked.workers, say)
    lines = [line(a) for a in answers]
    halves = both_halves([a for a, one in zip(answers, lines, strict=True) if one.score is not None])
    required = rows(lines, halves)
    text = "\n".join([head(answers, asked), rows_table(required), cases_table(lines), halves_table(halves)])
    print(text)
    _write(out / "table.md", text)
    if asked.write or not (asked.only or asked.table):
        for file, heading in HEADING.items():
            _write(file, replaced(file.read_text(encoding="utf-8"), heading, text))
        _write(DOCS, replaced(DOCS.read_text(encoding="utf-8"), KNOWN, facts_table(facts())))
    return int(not all(r.met for r in required))


def data_folder() -> Path:
    """Return the folder of real recordings; `InputError` where IMUBENCH_DATA names none."""
    folder = os.environ.get("IMUBENCH_DATA", "")
    if not folder or not Path(folder).is_dir():
        raise InputError(f"IMUBENCH_DATA: expected the folder of real recordings, got '{folder}'")
    return Path(folder)


def run(some: Sequence[Case], out: Path, limit: float, workers: int, say: Terminal) -> list[Answer]:
    """Return the answer to every case, diagnosing those that no earlier run has; those with a baseline come last."""
    children, found, done = Children(), dict[str, Answer](), 0
    stages = ([c for c in some if not c.baseline], [c for c in some if c.baseline])
    with ThreadPoolExecutor(max(workers, 1)) as pool:
        try:
            for stage in stages:
                pending = {pool.submit(answered, c, out, limit, children): c for c in stage}
                for future in as_completed(pending):
                    answer, done = future.result(), done + 1
                    found[answer.case.name] = answer
                    say.say(f"{done} of {len(some)}: {in_a_line(line(answer))}")
        except BaseException:
            children.stop()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return [found[c.name] for c in some]


def line(answer: Answer) -> Line:
    """Return a case's line of the table."""
    fact, step = fact_of(answer.case.name), answer.diagnosing
    if step is None:
        return Line(answer.case.name, fact.known, shown(answer.why_not, answer.folder))
    if not answer.diagnosed:
        why = shown(f"no diagnosis: {step.failed or 'nothing written'}", answer.folder)
        return Line(answer.case.name, fact.known, why, None, step.seconds, step.memory)
    try:
        said = read_said(answer.folder / "diagnosis")
    except InputError as error:
        why = shown(f"diagnosis cannot be read: {error}", answer.folder)
        return Line(answer.case.name, fact.known, why, None, step.seconds, step.memory)
    score = scored(said, fact, answer.estimates("raw"), answer.estimates("with"), answer.axes)
    return Line(answer.case.name, fact.known, "", score, step.seconds, step.memory)


def shown(text: str, folder: Path) -> str:
    """Return a message about a case without this machine's folders, as a table may have it."""
    places = {
        str(folder): "",
        os.environ.get("IMUBENCH_DATA", ""): "IMUBENCH_DATA",
        str(ROOT): "",
        sys.prefix: "",
        str(Path.home()): "~",
    }
    for place, name in places.items():
        text = text.replace(place, name) if place else text
    return text


def in_a_line(one: Line) -> str:
    """Return what came out of a case, for people who wait."""
    s = one.score
    if s is None:
        return f"{one.name}: {one.failed}"
    said = f"wrong but explained: {'; '.join(s.wrong)}" if s.wrong else s.verdict
    return f"{one.name}: {said}; {one.seconds:.0f} s of processor time, {one.memory:.2f} GB"


def both_halves(answers: Sequence[Answer]) -> list[Halves]:
    """Return what the halves of each recording say of one another, where both are among the answers."""
    by_name = {a.case.name: a for a in answers}
    out = []
    for name, one in by_name.items():
        other = by_name.get(name.replace("/half1", "/half2"))
        if not name.endswith("/half1") or other is None:
            continue
        recording = read(one.folder / "recording")[0]
        mine, theirs = (read_said(a.folder / "diagnosis") for a in (one, other))
        findings = repeated(mine, theirs, recording.imus[0].rate)
        raw, corrected = (moved(one.estimates(w), other.estimates(w)) for w in ("raw", "with"))
        out.append(Halves(one.case.source.name, findings, raw, corrected))
    return out


def head(answers: Sequence[Answer], asked: argparse.Namespace) -> str:
    """Return how and where the tables were made, and how much of the suite is in them."""
    steps = [a.diagnosing for a in answers if a.diagnosing is not None]
    limits = ", ".join(sorted({f"{s.limit:g}" for s in steps})) or "none"
    commits = ", ".join(sorted({s.commit for s in steps})) or "none"
    there = sum(a.diagnosed for a in answers)
    command = "make real" if not (asked.only or asked.table) else "python -m benchmarks.real, a part"
    return (
        f"`{command}`, at most {limits} s of processor time a case, {datetime.now(UTC):%Y-%m-%d}, commit {commits}; "
        f"{os.cpu_count()} cores, {processor()}, Python {platform.python_version()}. {there} of {len(answers)} cases "
        "have a diagnosis.\n"
    )


def _write(file: Path, text: str) -> None:
    with atomic_file(file) as partial:
        partial.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
