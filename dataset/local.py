"""Processes of this machine make the pieces."""

from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait

from imubench.dataset.work import Piece, Work
from imubench.errors import InputError
from imubench.workers import WorkerError, cores, process_pool

PATIENCE = 3  # deaths of workers in a row without a finished piece, until it is no accident


def check(workers: int | None, address: str | None) -> None:
    """Raise `InputError` for an address: there is none to go to."""
    if address is not None:
        raise InputError(f"address: expected one with the engine ray alone, got '{address}' with local")


def run(
    work: Work[Piece], numbers: Sequence[int], workers: int | None, address: str | None = None
) -> Generator[Piece, None, None]:
    """Yield each piece; with `workers` = 0 they are made in this process, with None by one a core.

    A worker that dies takes its pool with it: what is not finished goes to a new one.
    """
    workers = cores() if workers is None else workers
    if workers == 0:
        yield from (work.make(number) for number in numbers)
        return
    left, deaths = dict.fromkeys(numbers), 0
    while left:
        try:
            for piece in _pooled(work, list(left), min(workers, len(left))):
                del left[piece.number]
                deaths = 0
                yield piece
        except WorkerError:
            for piece in filter(None, [work.finished(number) for number in left]):  # made, and not told about
                del left[piece.number]
                yield piece
            deaths += 1
            if deaths == PATIENCE:
                raise InputError(
                    f"{work.out}: expected workers that live, got {deaths} deaths in a row while shards "
                    f"{', '.join(map(str, list(left)[:workers]))} were made; is there enough memory?"
                ) from None


def _pooled(work: Work[Piece], numbers: Sequence[int], workers: int) -> Generator[Piece, None, None]:
    """Yield pieces; what workers were writing when the caller stops has no name yet, and the next run removes it."""
    with process_pool(workers) as pool:
        waiting = iter(numbers)
        pending: set[Future[Piece]] = set()
        while True:
            for number in waiting:
                pending.add(pool.submit(work.make, number))
                if len(pending) == 2 * workers:  # a job in hand for each, and no list of a million
                    break
            if not pending:
                break
            done, pending = wait(pending, return_when=FIRST_COMPLETED)
            yield from (future.result() for future in done)
