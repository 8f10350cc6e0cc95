"""A failing input made smaller by delta debugging, as long as it fails alike: lines, then pieces, then single bytes."""

from collections.abc import Callable, Sequence
from time import monotonic

from fuzz.pool import Pool
from fuzz.worker import Task

SECONDS = 15.0  # for one failure
TRIES = 400
SLOW = 5.0  # s that a failing input may take to be made smaller


def minimised(pool: Pool, task: Task, content: bytes, what: str) -> bytes:
    """Return the smallest content found that fails in the same way."""
    start, tries = monotonic(), 0

    def fails(candidate: bytes) -> bool:
        nonlocal tries
        tries += 1
        if tries > TRIES or monotonic() - start > SECONDS:
            return False
        return pool.one(Task(task.reader, content=candidate, command=task.command)).what == what

    if not fails(content):  # it depends on more than its content
        return content
    if monotonic() - start > SLOW:
        return content
    content = b"".join(_fewer(content.splitlines(keepends=True), fails))
    size = len(content)
    while size > 1:
        size = max(1, size // 4)
        pieces = [content[i : i + size] for i in range(0, len(content), size)]
        content = b"".join(_fewer(pieces, fails))
    return content


def _fewer(pieces: Sequence[bytes], fails: Callable[[bytes], bool]) -> list[bytes]:
    """Return pieces of which none can be left out: ever smaller runs of them are tried (Zeller's ddmin)."""
    left, run = list(pieces), len(pieces) // 2
    while run:
        at = 0
        while at < len(left):
            without = left[:at] + left[at + run :]
            if without and fails(b"".join(without)):
                left = without
            else:
                at += run
        run //= 2
    return left
