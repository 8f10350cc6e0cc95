"""What a command is made of, and the options that several have."""

import re
from collections.abc import Callable, Container
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from imubench.errors import InputError, shortened
from imubench.terminal import Terminal

console = Terminal()
errors = Terminal(stderr=True)

Band = Annotated[
    float | None,
    typer.Option("--band", help="Hz: filter the IMUs below it, forward and backward, first.", show_default=False),
]
RECORDING = "A folder in format 1, or DIR#17: recording 17 of a dataset."
Out = Annotated[Path | None, typer.Option("--out", help="Folder for the results.", show_default=False)]
TimeLimit = Annotated[
    float | None,
    typer.Option("--time-limit", help="Seconds by the clock for the estimator; then it counts as hanging.", min=0.01),
]


@dataclass(frozen=True)
class Command:
    """A command of `imubench`: its docstring and the types of its arguments are its help."""

    name: str
    function: Callable[..., None]
    examples: tuple[str, ...]  # as they are typed

    @property
    def epilogue(self) -> str:
        """The end of its help: each example a paragraph of its own, or they would be run together."""
        return "\n\n".join(["Examples:", *self.examples])


def say_written(out: Path, rrd: str | None = None) -> None:
    """Say where the results are."""
    console.say(f"written: {out}" + (f"; look at it with: rerun {out / rrd}" if rrd else ""))


def folder_name(name: str) -> str:
    """Return a name as one of a folder, for a default --out: `olsson2020/motion-11` becomes `olsson2020-motion-11`."""
    return re.sub(r"[^\w.+-]+", "-", name).strip("-.") or "run"


def check_order(first: str, second: str, known: Container[str], command: str) -> None:
    """Raise `InputError` where the two arguments of a command come the other way round.

    Args:
        first: what came first, where one of the known names was expected.
        second: what came second.
        known: the names.
        command: as it is typed.
    """
    if first not in known and second in known:
        raise InputError(f"{command}: expected {second} before {shortened(first, 60)}, got them the other way round")
