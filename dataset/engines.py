"""Engines hand shards to whoever makes them. A new one is one function and one line in `ENGINES`."""

from collections.abc import Callable, Generator, Sequence

from imubench.dataset import local
from imubench.dataset.shard import Job, Receipt

Engine = Callable[[Job, Sequence[int], int], Generator[Receipt, None, None]]
"""Takes a job, the numbers of the shards to make, and how many workers; yields a receipt for each, in any order.

A worker that dies is an engine's own affair: the shard is made again. `InputError` of a worker goes on to the caller.
When the caller stops, by Ctrl-C or an error, no worker goes on.
"""

ENGINES: dict[str, Engine] = {
    "local": local.run,
}
"""The engines by name."""
