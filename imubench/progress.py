"""Progress of steps that may take more than two seconds."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from time import monotonic

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.text import Text

from imubench.errors import printable
from imubench.terminal import Terminal

Step = Callable[[str], AbstractContextManager[None]]
"""Takes what is being done; the context lasts as long as it takes."""

Report = Callable[[str, int, int], None]
"""Takes the stage, how many of it are done, and how many there are."""

READING = "read "
"""How a stage begins that reads what it was given: no line says so, for broken input is answered by one line."""

_listener: ContextVar[Callable[[str], None] | None] = ContextVar("listener", default=None)


@contextmanager
def silent(what: str) -> Iterator[None]:
    """Show nothing."""
    yield


def tell(detail: str) -> None:
    """Say what a stage is trying just now, to whoever shows it."""
    listener = _listener.get()
    if listener is not None:
        listener(detail)


@contextmanager
def bars(console: Terminal) -> Iterator[Report]:
    """Hand out a report that shows a bar for each stage on a terminal, and nothing elsewhere."""
    columns = (TextColumn("{task.description:<16}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
        tasks: dict[str, object] = {}

        def report(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = progress.add_task(stage, total=total)
            progress.update(tasks[stage], completed=done)  # type: ignore[arg-type]

        yield report


def on_console(console: Terminal) -> Step:
    """Return a step that shows what is being done on a terminal, and nothing elsewhere."""

    @contextmanager
    def step(what: str) -> Iterator[None]:
        with console.status(Text(f"{printable(what)} ...")):
            yield

    return step


class Stage:
    """One stage of some as it is shown: its number, the time since the first began, and what is being tried."""

    def __init__(self, what: str, number: int, count: int, began: float) -> None:
        self.what, self.number, self.count, self.began = what, number, count, began
        self.detail = ""

    def __str__(self) -> str:
        """The stage in a line."""
        trying = f": {self.detail}" if self.detail else ""
        return printable(f"{self.number} of {self.count}, {monotonic() - self.began:.0f} s: {self.what}{trying}")

    def __rich__(self) -> Text:
        """As it stands beside a spinner: the seconds go on while it turns."""
        return Text(str(self), no_wrap=True, overflow="ellipsis")


def in_stages(console: Terminal, plan: Sequence[str]) -> Step:
    """Return a step that says which stage of a plan runs, how long all has taken, and what is being tried.

    On a terminal it is one line that changes. Elsewhere every stage has a plain line when it begins, but for those that
    read what was given.

    Args:
        console: where it is shown.
        plan: the stages' names in their order, as far as they are known before; a stage may be left out, and one that
            is not in the plan counts as the next. Where one begins again, so do those after it.
    """
    began = monotonic()
    at, shown = 0, set[int]()

    @contextmanager
    def step(what: str) -> Iterator[None]:
        nonlocal at
        places = (i for i, name in enumerate(plan) if what.startswith(name))
        found = next((i for i in places if i >= at or i in shown), None)
        shown.update([] if found is None else [found])
        at = (at if found is None else found) + 1
        stage = Stage(what, at, max(at, len(plan)), began)

        def trying(detail: str) -> None:
            stage.detail = detail

        token = _listener.set(trying)
        try:
            if console.is_terminal:
                with console.status(stage):
                    yield
            else:
                if not what.startswith(READING):
                    console.say(str(stage))
                yield
        finally:
            _listener.reset(token)

    return step


__all__ = ["Step", "in_stages", "on_console", "silent", "tell"]
