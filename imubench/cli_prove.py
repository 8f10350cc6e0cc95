"""`imubench prove`: bars of what is done, the seal before the first diagnosis, the figures, exit code."""

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from imubench.reproduce.parts import cores
from imubench.trials.figures import numbers
from imubench.trials.prove import Proof, prove
from imubench.trials.seal import check_proof
from imubench.trials.sealed import seal as seal_truth
from imubench.trials.settings import Settings
from imubench.trials.stages import Report

COLOURS = {"holds": "green", "fails": "red", "open": "yellow", "none": "dim"}


def new_seed() -> int:
    """Return a seed that nobody can guess."""
    return secrets.randbits(62)


def run(settings: Settings, out: Path, workers: int | None, console: Console, errors: Console) -> int:
    """Do the trials into `out`, print what came out, and return the exit code."""

    def announce(sealed: str) -> None:
        console.print(f"sealed: SHA-256 of commitments.json {sealed}", soft_wrap=True)

    try:
        with bars(errors) as report:
            proof = prove(settings, out, workers or cores(), report, announce)
    except KeyboardInterrupt:
        errors.print("what was finished is kept beside --out: the same command goes on from there")
        raise
    print_proof(proof, console)
    console.print(f"written: {out}; open {out / 'report.html'}", soft_wrap=True)
    return 0 if proof.fit_for_the_build else 1


def check(folder: Path, console: Console) -> int:
    """Check the seals of a finished proof and return the exit code."""
    console.print(f"{check_proof(folder)} seals of {folder} are those of its truths")
    return 0


def seal(written: Path, console: Console) -> int:
    """Seal a documented truth and return the exit code."""
    name = written.name.removesuffix(".truth.json")
    console.print(f"sealed: {seal_truth(written)}", soft_wrap=True)
    console.print(f"publish {name}.commitment.json, keep {name}.sealed.json back until the diagnosis is done")
    return 0


@contextmanager
def bars(console: Console) -> Iterator[Report]:
    """Hand out a report that shows a bar for each stage on a terminal, and nothing elsewhere."""
    columns = (TextColumn("{task.description:<16}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
        tasks: dict[str, object] = {}

        def report(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = progress.add_task(stage, total=total)
            progress.update(tasks[stage], completed=done)  # type: ignore[arg-type]

        yield report


def print_proof(proof: Proof, console: Console) -> None:
    """Print a line for each figure, and what a diagnosis tried that it has no business with."""
    table = Table(box=None, header_style="bold", padding=(0, 2, 0, 0))
    for column in ("", "figure", "here", "95 % interval", "n", "aim"):
        table.add_column(column, justify="right" if column in ("here", "95 % interval", "n") else "left")
    for f in proof.figures:
        here, interval = numbers(f)
        verdict = f"[{COLOURS[f.verdict]}]{f.verdict if f.verdict != 'none' else ''}[/]"
        table.add_row(verdict, escape(f.title), here, interval, str(f.n), f.aim)
    console.print(table)
    for f in proof.figures:
        if f.passed:
            console.print(f"[red]guard passed[/]: {escape(f.title)}: {numbers(f)[0]}, expected {f.guard}")
    for name, what in proof.refused.items():
        console.print(f"[red]cheat[/]: the diagnosis of case {name} tried to {escape(what[0])}", soft_wrap=True)
