"""Progress of steps that may take more than two seconds."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from rich.text import Text

from imubench.errors import printable
from imubench.terminal import Terminal

Step = Callable[[str], AbstractContextManager[None]]
"""Takes what is being done; the context lasts as long as it takes."""


@contextmanager
def silent(what: str) -> Iterator[None]:
    """Show nothing."""
    yield


def on_console(console: Terminal) -> Step:
    """Return a step that shows what is being done on a terminal, and nothing elsewhere."""

    @contextmanager
    def step(what: str) -> Iterator[None]:
        with console.status(Text(f"{printable(what)} ...")):
            yield

    return step
