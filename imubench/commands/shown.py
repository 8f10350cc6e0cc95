"""Estimates and scores as a terminal shows them."""

from pathlib import Path

from rich.table import Table

from imubench.answers import moved
from imubench.commands.command import console
from imubench.estimate import Estimate, Failed
from imubench.estimators.banded import explained
from imubench.run import TRACE_FILE
from imubench.units import SHOWN


def say_figures(title: str, figures: dict[str, float], units: dict[str, str]) -> None:
    """Print figures with their units; angles in degrees, lengths in millimetres."""
    console.say(title, "italic")
    table = Table(box=None, header_style="bold")
    table.add_column("figure")
    table.add_column("value", justify="right")
    table.add_column("unit")
    for name, value in figures.items():
        unit, factor = SHOWN.get(units[name], (units[name], 1.0))
        table.add_row(name, f"{value * factor:.3f}", unit)
    console.print(table)


def say_note(note: str) -> None:
    """Print a note, if there is one."""
    if note:
        console.say(f"  {note}")


def say_moved(before: Estimate, answer: Estimate, names: list[str]) -> None:
    """Print by how much an estimate differs from that of the recording as it came."""
    if (by := moved(before, answer)) is None:
        return
    told = ", ".join(f"{name} {value:.2f} {by[1]}" for name, value in zip(names, by[0], strict=True))
    console.say(f"  moved by what was taken out: {told} (as it came: {before.status})")


def say_band(answer: Estimate) -> None:
    """Print in words which band an estimate is from, if it is from one."""
    words = explained(answer)
    if words:
        console.say(words)


def say_failed(failed: Failed, out: Path) -> None:
    """Print how an estimator failed, and where the trace of its error is."""
    console.say(failed.estimator, "bold", f" {failed.status}: {failed.why}")
    if failed.trace:
        console.say(f"  where in detail: {out / TRACE_FILE}")
