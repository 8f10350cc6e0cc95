"""The command line: each command writes its result into --out and prints what matters.

Exit codes: 0 done, 1 a limit or claim failed, 2 bad input, 70 an error of ours, 130 and 143 interrupted.
"""

from typing import Annotated

import typer

import imubench
from imubench.commands import (
    check,
    convert,
    datasets,
    diagnose,
    estimate,
    explain,
    list_known,
    prove,
    reproduce,
    run,
    sweep,
)
from imubench.commands.command import Command, console

COMMANDS: tuple[Command, ...] = (
    list_known.COMMAND,
    run.COMMAND,
    estimate.COMMAND,
    convert.COMMAND,
    reproduce.COMMAND,
    diagnose.COMMAND,
    explain.COMMAND,
    prove.COMMAND,
    sweep.COMMAND,
    check.COMMAND,
    datasets.GENERATE,
    datasets.VERIFY,
    datasets.EXPORT,
)
app = typer.Typer(
    name="imubench",
    help="A test bench for inertial joint calibration.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for command in COMMANDS:
    app.command(command.name, epilog=command.epilogue)(command.function)


@app.callback(invoke_without_command=True)
def version(show: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False) -> None:
    """A test bench for inertial joint calibration."""
    if show:
        console.print(imubench.__version__)
        raise typer.Exit
