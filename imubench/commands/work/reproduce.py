"""`imubench reproduce`: a bar of what is done, the verdicts; exit code 1 where a promise fails or a guard is broken."""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from imubench.reproduce.claims import Judged
from imubench.reproduce.paper import Part
from imubench.reproduce.parts import Report
from imubench.reproduce.reproduce import Watch, reproduce
from imubench.signals import promising
from imubench.terminal import Terminal

COLOURS = {"holds": "green", "fails": "red", "differs": "yellow"}


def run(
    paper: str,
    out: Path,
    quick: bool,
    seed: int,
    console: Terminal,
    errors: Terminal,
    estimators: Sequence[str] = (),
    seconds: float | None = None,
) -> int:
    """Reproduce a paper into `out`, print what came out, and return the exit code."""
    with promising("what was finished is kept beside --out: the same command goes on from there"):
        done = reproduce(paper, out, quick, seed, watching(errors), estimators=estimators, seconds=seconds)
    judged = done.judged
    if judged:
        print_verdicts(judged, console)
    if done.beside:
        console.say(done.beside)
    console.say(f"written: {out}; open {out / 'report.html'}")
    for j in judged:
        if j.news:
            errors.say("guard broken" if j.worse else "new", "red", f": {j.claim.claim}: {j.news}")
    return int(any(j.verdict == "fails" or j.worse for j in judged))


def watching(console: Terminal) -> Watch:
    """Return a watch that shows a bar on a terminal, and nothing elsewhere."""

    @contextmanager
    def watch(parts: list[Part]) -> Iterator[Report]:
        columns = (TextColumn("{task.description:<28}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
            left = Counter(part.stage for part in parts)
            tasks = {stage: progress.add_task(stage, total=count) for stage, count in left.items()}
            yield lambda part: progress.advance(tasks[part.stage])

    return watch


def print_verdicts(judged: list[Judged], console: Terminal) -> None:
    """Print one line a claim, the failed ones last, where they are seen."""
    order = {"holds": 0, "differs": 1, "fails": 2}
    table = Table(box=None, header_style="bold", padding=(0, 2, 0, 0))
    for column in ("", "claim", "paper", "here", "bound"):
        table.add_column(column, justify="right" if column in ("paper", "here") else "left")
    for j in sorted(judged, key=lambda j: order[j.verdict]):
        c, value = j.claim, j.measured.value
        here = f"{value:.3g}" if abs(value) < float("inf") else "none"
        verdict = Text(j.verdict, COLOURS[j.verdict])
        table.add_row(verdict, c.claim, f"{c.published:g}", here, c.bound)
    console.print(table)
    counts = Counter(j.verdict for j in judged)
    console.print(", ".join(f"{counts[v]} {v}" for v in ("holds", "differs", "fails") if counts[v]))
