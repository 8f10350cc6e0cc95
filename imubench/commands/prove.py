"""`imubench prove`: blind trials of the diagnosis."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from imubench.commands.command import Command, Out, console, errors


def prove_command(
    cases: Annotated[int, typer.Option(help="How many recordings.", min=1)] = 20,
    seed: Annotated[
        int | None, typer.Option(help="The same seed gives the same cases; none: one that nobody knows.")
    ] = None,
    diagnosis: Annotated[str | None, typer.Option(help="Another diagnosis: words with {recording} and {out}.")] = None,
    seconds: Annotated[float | None, typer.Option(help="Recordings of at most so many seconds.", min=5)] = None,
    timeout: Annotated[float, typer.Option(help="Seconds until a diagnosis is stopped.", min=1)] = 300.0,
    workers: Annotated[int | None, typer.Option(help="Diagnoses at a time; none: one a core.", min=1)] = None,
    baselines: Annotated[bool, typer.Option("--baselines", help="L1 and the oracle on the same cases.")] = False,
    added: Annotated[Path | None, typer.Option(help="Add effects to the real recordings in this folder.")] = None,
    real: Annotated[Path | None, typer.Option(help="Recordings with sealed sidecars in this folder instead.")] = None,
    crime: Annotated[bool, typer.Option("--crime", help="Again with data from the project's own simulator.")] = False,
    leave_one_out: Annotated[bool, typer.Option("--leave-one-out", help="Again without the effect found.")] = False,
    check: Annotated[Path | None, typer.Option(help="Only check the seals of a finished proof in this folder.")] = None,
    seal: Annotated[Path | None, typer.Option(help="Only seal NAME.truth.json beside the recording NAME.")] = None,
    out: Out = None,
) -> None:
    """Blind trials of the diagnosis: proof.json, report.html.

    An independent generator makes recordings with concealed effects. A hash of
    every truth is published before the first diagnosis starts; each diagnosis
    runs in a process that has the recording and nothing else. Then the truths
    are opened, checked against the hashes, and scored.

    After Ctrl-C or a kill the same command goes on where it was. Exit code 1
    when a guard of limits.toml is broken or a diagnosis tried to see more.
    """
    from imubench.commands.work import prove as work
    from imubench.trials.settings import Settings

    if check is not None:
        raise typer.Exit(work.check(check, console))
    if seal is not None:
        raise typer.Exit(work.seal(seal, console))
    if seed is None:
        seed = 0 if real else work.new_seed()  # nothing is drawn for recordings that are there
    settings = Settings(cases, seed, timeout=timeout, seconds=seconds)
    settings = replace(
        settings,
        baselines=baselines,
        leave_one_out=leave_one_out,
        added=str(added or ""),
        real=str(real or ""),
        crime=crime,
    )
    if diagnosis is not None:
        settings = replace(settings, command=diagnosis)
    raise typer.Exit(work.run(settings, out or Path("runs/proof"), workers, console, errors))


COMMAND = Command(
    "prove",
    prove_command,
    ("imubench prove --cases 20 --seconds 12", "imubench prove --check runs/proof"),
)
