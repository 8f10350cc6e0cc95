"""`imubench explain`: a name in plain words."""

from typing import Annotated

import typer

from imubench.commands.command import Command, Out, console


def explain_command(
    name: Annotated[str, typer.Argument(help="An effect, figure or word of a result, or a name of `imubench list`.")],
    out: Out = None,
) -> None:
    """Explain an effect, a figure, a word or what is listed; with --out also as explain.json."""
    from imubench.commands.work.explain import run as run_explain

    run_explain(name, out, console)


COMMAND = Command("explain", explain_command, ("imubench explain soft_mount", "imubench explain 'held out'"))
