"""`imubench explain`: a name in plain words."""

from typing import Annotated

import typer

from imubench.commands.command import Command, Out, console


def explain_command(
    name: Annotated[str, typer.Argument(help="An effect, a figure or a word of a result.")], out: Out = None
) -> None:
    """Explain an effect, a figure or a word in plain words; with --out also as explain.json."""
    from imubench.cli_explain import run as run_explain

    run_explain(name, out, console)


COMMAND = Command("explain", explain_command, ("imubench explain soft_mount", "imubench explain 'held out'"))
