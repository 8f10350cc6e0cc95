"""Engines hand pieces of work to whoever makes them: shards of a dataset, cells of a sweep.

A new one is one module with two functions and one line in `ENGINES`.
"""

from collections.abc import Generator, Sequence
from typing import Protocol

from imubench.dataset import local, on_ray
from imubench.dataset.work import Piece, Work


class Engine(Protocol):
    """What the module of an engine has."""

    def check(self, workers: int | None, address: str | None) -> None:
        """Raise `InputError`, before anything is written, where nothing can be made so."""

    def run(
        self, work: Work[Piece], numbers: Sequence[int], workers: int | None, address: str | None
    ) -> Generator[Piece, None, None]:
        """Yield the pieces of these numbers, in any order; workers None: one a core.

        A worker that dies is an engine's own affair: its piece is made again. `InputError` of a worker goes on to the
        caller. When the caller stops, by Ctrl-C or an error, no worker goes on.
        """
        ...


ENGINES: dict[str, Engine] = {
    "local": local,
    "ray": on_ray,
}
"""The engines by name."""
