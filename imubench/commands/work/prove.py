"""`imubench prove`: bars of what is done, the seal before the first diagnosis, the figures, exit code."""

import secrets
from pathlib import Path

from rich.table import Table
from rich.text import Text

from imubench.progress import bars
from imubench.signals import promising
from imubench.terminal import Terminal
from imubench.trials.figures import numbers
from imubench.trials.prove import Proof, prove
from imubench.trials.seal import check_proof
from imubench.trials.sealed import seal as seal_truth
from imubench.trials.settings import Settings
from imubench.workers import cores

COLOURS = {"holds": "green", "fails": "red", "open": "yellow", "none": "dim"}


def new_seed() -> int:
    """Return a seed that nobody can guess."""
    return secrets.randbits(62)


def run(settings: Settings, out: Path, workers: int | None, console: Terminal, errors: Terminal) -> int:
    """Do the trials into `out`, print what came out, and return the exit code."""

    def announce(sealed: str) -> None:
        console.say(f"sealed: SHA-256 of commitments.json {sealed}")

    kept = "what was finished is kept beside --out: the same command goes on from there"
    with promising(kept), bars(errors) as report:
        proof = prove(settings, out, workers or cores(), report, announce)
    print_proof(proof, console)
    console.say(f"written: {out}; open {out / 'report.html'}")
    return 0 if proof.fit_for_the_build else 1


def check(folder: Path, console: Terminal) -> int:
    """Check the seals of a finished proof and return the exit code."""
    console.say(f"{check_proof(folder)} seals of {folder} are those of its truths")
    return 0


def seal(written: Path, console: Terminal) -> int:
    """Seal a documented truth and return the exit code."""
    name = written.name.removesuffix(".truth.json")
    console.say(f"sealed: {seal_truth(written)}")
    console.say(f"publish {name}.commitment.json, keep {name}.sealed.json back until the diagnosis is done")
    return 0


def print_proof(proof: Proof, console: Terminal) -> None:
    """Print a line for each figure, and what a diagnosis tried that it has no business with."""
    table = Table(box=None, header_style="bold", padding=(0, 2, 0, 0))
    for column in ("", "figure", "here", "95 % interval", "n", "aim"):
        table.add_column(column, justify="right" if column in ("here", "95 % interval", "n") else "left")
    for f in proof.figures:
        here, interval = numbers(f)
        verdict = Text(f.verdict if f.verdict != "none" else "", COLOURS[f.verdict])
        table.add_row(verdict, f.title, here, interval, str(f.n), f.aim)
    console.print(table)
    for f in proof.figures:
        if f.passed:
            console.say("guard broken", "red", f": {f.title}: {numbers(f)[0]}, expected {f.guard}")
    for name, what in proof.refused.items():
        console.say("cheat", "red", f": the diagnosis of case {name} tried to {what[0]}")
