"""Engines hand shards to whoever makes them. A new one is one module with two functions and one line in `ENGINES`."""

from collections.abc import Generator, Sequence
from typing import Protocol

from imubench.dataset import local, on_ray
from imubench.dataset.shard import Job, Receipt


class Engine(Protocol):
    """What the module of an engine has."""

    def check(self, workers: int | None, address: str | None) -> None:
        """Raise `InputError`, before anything is written, where shards cannot be made so."""

    def run(
        self, job: Job, shards: Sequence[int], workers: int | None, address: str | None
    ) -> Generator[Receipt, None, None]:
        """Yield a receipt for each of the numbers of the shards to make, in any order; workers None: one a core.

        A worker that dies is an engine's own affair: the shard is made again. `InputError` of a worker goes on to the
        caller. When the caller stops, by Ctrl-C or an error, no worker goes on.
        """
        ...


ENGINES: dict[str, Engine] = {
    "local": local,
    "ray": on_ray,
}
"""The engines by name."""
