"""Inputs that once made a reader fail, and what may stand in the place of a file: accepted, or refused in one line."""

import pytest

from fuzz.bombs import BOMBS
from fuzz.corpus import LARGEST, entries
from fuzz.pool import Pool
from fuzz.readers import READERS
from fuzz.scratch import PLACES
from fuzz.worker import Task

KEPT = list(entries())


@pytest.fixture(scope="module")
def pool():
    with Pool(1) as workers:
        yield workers


def holds(pool, task):
    outcome = pool.one(task)
    assert outcome.verdict in ("accepted", "refused"), f"{outcome.what}\n{outcome.said}"


@pytest.mark.parametrize(("reader", "file"), KEPT, ids=[f"{reader}-{file.stem}" for reader, file in KEPT])
def test_a_kept_input(reader, file, pool):
    content = file.read_bytes()
    assert len(content) <= LARGEST
    holds(pool, Task(reader, content=content))
    if READERS[reader].words is not None:
        holds(pool, Task(reader, content=content, command=True))


OWN = ("lock", "real-kept", "proof-kept", "proof-no-baseline")
"""What a run keeps for itself: where it is not there it is made, which is no change of an input."""

HANDED_OVER = [
    name
    for name, reader in READERS.items()
    if name not in OWN and not reader.as_text and not name.endswith("-options")  # options are no file
]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("reader", HANDED_OVER)
def test_something_in_the_place_of_a_file(reader, place, pool):
    """A pipe that nobody writes to, an endless device, a file of 10 GB, a link to itself: nothing waits or grows.

    A whole command meets the pipe alone: it opens files as its reader does, and what waits at all waits there.
    """
    command = place == "pipe" and READERS[reader].words is not None
    holds(pool, Task(reader, content=b"", place=place, command=command))


SHOWN = {bomb: name for name, reader in reversed(READERS.items()) for bomb in BOMBS.get(reader.mutate, ())}
"""The first reader of each kind of file; the others read it through the same module, and are marked long."""


@pytest.mark.long
@pytest.mark.parametrize(
    ("reader", "bomb"),
    [
        pytest.param(name, bomb, marks=() if SHOWN[bomb] == name else pytest.mark.long)
        for name, reader in READERS.items()
        for bomb in BOMBS.get(reader.mutate, ())
    ],
    ids=lambda value: value if isinstance(value, str) else value.__name__,
)
def test_a_small_file_that_is_large_in_memory(reader, bomb, pool):
    found = READERS[reader]
    holds(pool, Task(reader, content=bomb(found.files()[found.target])))
