"""`imubench check`: claims about an estimator, decided by as few runs as their confidence needs."""

from pathlib import Path
from typing import Annotated

import typer

from imubench.commands.command import Command, Out, console, errors
from imubench.inputs.files import real


def check_command(
    claims: Annotated[Path, typer.Argument(help="A TOML file of claims, docs/your-claim.md.")],
    estimator: Annotated[
        str | None, typer.Option(help="Take this one, whatever the file says.", show_default=False)
    ] = None,
    only: Annotated[list[str] | None, typer.Option(help="A claim by name; may be given again.")] = None,
    against: Annotated[
        Path | None, typer.Option("--against", help="Also compare with the claims.json of an earlier check.")
    ] = None,
    save_baseline: Annotated[
        Path | None, typer.Option("--save-baseline", help="Also write claims.json here, of 400 runs or more.")
    ] = None,
    runs: Annotated[int | None, typer.Option(help="Make so many at least, decided or not.", min=1)] = None,
    seed: Annotated[int, typer.Option(help="Number of the first run.", min=0)] = 0,
    workers: Annotated[int | None, typer.Option(help="Processes; none: one a core.", min=1)] = None,
    out: Out = None,
) -> None:
    """Check claims about an estimator: claims.json, junit.xml, summary.md.

    A claim names an estimator, a scenario, a figure with its bound and how sure
    to be. Recordings are simulated until the claim is confirmed or refuted; how
    many it took is said, and so are the two error rates.

    With --against each claim is also compared with what an earlier check found
    on the same runs: it fails where errors have become larger.

    After Ctrl-C or a kill the same command goes on where it was. Exit code 1
    when a claim fails or stays undecided. In a workflow of GitHub the summary
    is shown with the step.
    """
    from imubench.commands.work.check import run as run_check

    target = out or Path("runs") / f"check-{real(claims).stem}"
    code = run_check(
        claims, target, estimator, only or [], against, save_baseline, runs, seed, workers, console, errors
    )
    raise typer.Exit(code)


COMMAND = Command(
    "check",
    check_command,
    (
        "imubench check claims.toml",
        "imubench check claims.toml --save-baseline baseline.json",
        "imubench check claims.toml --against baseline.json --estimator mine.py:estimate",
    ),
)
