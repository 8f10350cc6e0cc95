"""How much processor time a diagnosis may take.

The work asks at its natural steps, `check`: before every step of a fit and every piece of work that goes to a thread.
Where the time of its part is spent that raises `OutOfTime`, and whoever has a result so far goes on with that. What
has to be done whatever the time, as writing the report, runs outside any part and is not stopped.
"""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from time import process_time

_end: ContextVar[float] = ContextVar("end", default=float("inf"))


class OutOfTime(Exception):  # noqa: N818  # not an error: the time of a part of the work is spent
    """The processor time of a part of the work is spent."""


def check() -> None:
    """Raise `OutOfTime` where this part of the work has had its time; worker threads count, and are asked, too."""
    end = _end.get()
    if end < float("inf") and process_time() > end:
        raise OutOfTime


@dataclass
class Budget:
    """The processor time of one diagnosis, and what it was too short for."""

    limit: float = float("inf")  # s, of all threads
    began: float = field(default_factory=lambda: process_time())
    not_tried: list[str] = field(default_factory=list)

    @contextmanager
    def part(self, share: float, what: str) -> Iterator[None]:
        """Let a block run until a share of the limit is spent, from the beginning on; then note `what` and go on.

        What the block has assigned by then stays.
        """
        token = _end.set(min(_end.get(), self.began + share * self.limit))
        try:
            yield
        except OutOfTime:
            self.missed(what)
        finally:
            _end.reset(token)

    def rest(self, what: str) -> AbstractContextManager[None]:
        """Let a block run until the limit; then note `what` and go on."""
        return self.part(1.0, what)

    def missed(self, *what: str) -> None:
        """Note what was not tried."""
        self.not_tried += [w for w in what if w not in self.not_tried]

    @property
    def stopped(self) -> str:
        """What stopped the diagnosis, in words; empty where nothing did."""
        return f"time limit of {self.limit:g} s of processor time" if self.not_tried else ""


__all__ = ["Budget", "OutOfTime", "check"]
