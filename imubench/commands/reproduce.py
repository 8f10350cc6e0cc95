"""`imubench reproduce`: a paper's figures, tables and claims again."""

from pathlib import Path
from typing import Annotated

import typer

from imubench.commands.command import Command, Out, console, errors

QUICK = "Fewer runs and starts. Processor time, shared by all cores: arve half a minute, olsson2020 one and a half."


def reproduce_command(
    paper: Annotated[str, typer.Argument(help="A paper, as `imubench list` names it under claims.")],
    quick: Annotated[bool, typer.Option("--quick", help=QUICK)] = False,
    seed: Annotated[int, typer.Option(help="The same seed gives the same numbers.", min=0)] = 0,
    estimator: Annotated[
        list[str] | None,
        typer.Option(
            "--estimator",
            help="Also give the paper's recordings to this one, as `run` takes it; any number of them.",
            show_default=False,
        ),
    ] = None,
    time_limit: Annotated[
        float, typer.Option("--time-limit", help="Seconds by the clock for one estimate by --estimator.", min=0.01)
    ] = 60.0,
    out: Out = None,
) -> None:
    """Reproduce every figure, table and claim of a paper: claims.json, report.html.

    With --estimator the report has a table of other estimators beside the
    paper's own method, on the paper's recordings, and so has beside.json. The
    claims stay those about the paper's method. What crashes, hangs or answers
    NaN is told in its place, and stops nothing.

    Runs on all cores. After Ctrl-C the same command goes on where it was. Exit
    code 1 when a claim fails or a guard is broken.
    """
    from imubench.commands.work.reproduce import run as run_reproduction

    out = out or Path("runs") / paper
    raise typer.Exit(run_reproduction(paper, out, quick, seed, console, errors, estimator or (), time_limit))


COMMAND = Command(
    "reproduce",
    reproduce_command,
    (
        "imubench reproduce olsson2020 --quick",
        "imubench reproduce arve --out arve",
        "imubench reproduce olsson2020 --quick --estimator mine.py:estimate",
    ),
)
