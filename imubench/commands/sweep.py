"""`imubench sweep`: errors of estimators over one or two numbers of a rig, motion, IMU or effect."""

from pathlib import Path
from typing import Annotated

import typer

from imubench.commands.command import Command, Out, console, errors


def sweep_command(
    spec: Annotated[Path, typer.Argument(help="A dataset's spec with one or two axis tables.")],
    estimator: Annotated[
        list[str],
        typer.Option(
            "--estimator",
            help="An estimator of `imubench list`, FILE.py:FUNCTION or PACKAGE.MODULE:FUNCTION; any number of them.",
        ),
    ],
    seed: Annotated[int, typer.Option(help="The same seed gives the same recordings.", min=0, max=2**63 - 1)] = 0,
    recordings: Annotated[
        int | None, typer.Option(help="In each cell, instead of the spec's.", min=1, show_default=False)
    ] = None,
    time_limit: Annotated[
        float, typer.Option("--time-limit", help="Seconds by the clock for one estimate.", min=0.01)
    ] = 60.0,
    workers: Annotated[int | None, typer.Option(help="Processes; none: one a core, 0: only this one.", min=0)] = None,
    engine: Annotated[str, typer.Option(help="Who does the work: local or ray.")] = "local",
    address: Annotated[str | None, typer.Option(help="Of the Ray cluster.", show_default=False)] = None,
    out: Out = None,
) -> None:
    """Map the errors of estimators over one or two numbers of a rig, motion, IMU or effect.

    Written are sweep.parquet and sweep.csv, a row for each cell and estimator,
    recordings.parquet, sweep.json, and report.html with a map for each
    estimator and a contour at the spec's limit. Without --out: runs/NAME.

    After Ctrl-C or a kill the same command goes on where it was, to the same
    bytes. What cannot be played, and an estimator that fails, are shown so.
    """
    from imubench.commands.work.sweep import run as run_sweep

    run_sweep(spec, estimator, seed, recordings, time_limit, workers, engine, address, out, console, errors)


COMMAND = Command(
    "sweep",
    sweep_command,
    (
        "imubench sweep sweep.toml --estimator seel2012 --estimator olsson2020",
        "imubench sweep sweep.toml --estimator mine.py:estimate --recordings 3 --out quick",
    ),
)
