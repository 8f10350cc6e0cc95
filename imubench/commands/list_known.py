"""`imubench list`: what there is."""

import json
from typing import Annotated

import typer

from imubench.commands.command import Command, Out, console
from imubench.errors import unknown


def list_command(
    kind: Annotated[str | None, typer.Argument(help="Only these: rigs, scenarios, estimators, ...")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    out: Out = None,
) -> None:
    """List rigs, scenarios, estimators, effects, claims and more, one line each."""
    from imubench.listing import KINDS, known

    if kind is None:
        names = known()
    elif kind in KINDS:
        names = {kind: KINDS[kind]()}
    else:
        raise unknown("kind", kind, KINDS)
    content = {kind: [{"name": n, "summary": s} for n, s in entries.items()] for kind, entries in names.items()}
    if out is not None:
        from imubench.answers import write_json
        from imubench.atomic import atomic_directory

        with atomic_directory(out) as folder:
            write_json(folder / "list.json", content)
    if as_json:
        print(json.dumps(content, indent=2))
        return
    width = max((len(name) for entries in names.values() for name in entries), default=0)
    for kind, entries in names.items():
        console.say(kind + ("" if entries else "  (none yet)"), "bold")
        for name, summary in entries.items():
            console.say(f"  {name:<{width}}  {summary}")


COMMAND = Command("list", list_command, ("imubench list", "imubench list scenarios", "imubench list effects --json"))
