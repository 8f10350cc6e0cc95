"""Processes of this machine make the shards."""

import multiprocessing
import os
import threading
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait as wait_for

from imubench.dataset.shard import Job, Receipt, finished, make_shard
from imubench.errors import InputError
from imubench.reproduce.parts import cores, ignore_interrupts, one_thread_each

PATIENCE = 3  # deaths of workers in a row without a finished shard, until it is no accident


def check(workers: int | None, address: str | None) -> None:
    """Raise `InputError` for an address: there is none to go to."""
    if address is not None:
        raise InputError(f"address: expected one with the engine ray alone, got '{address}' with local")


def run(
    job: Job, shards: Sequence[int], workers: int | None, address: str | None = None
) -> Generator[Receipt, None, None]:
    """Yield the receipt of each shard; with `workers` = 0 they are made in this process, with None by one a core.

    A worker that dies takes its pool with it: what is not finished goes to a new one.
    """
    workers = cores() if workers is None else workers
    if workers == 0:
        yield from (make_shard(job, number) for number in shards)
        return
    left, deaths = dict.fromkeys(shards), 0
    while left:
        try:
            for receipt in _pooled(job, list(left), min(workers, len(left))):
                del left[receipt.number]
                deaths = 0
                yield receipt
        except BrokenProcessPool:
            for receipt in filter(None, [finished(job, number) for number in left]):  # made, and not told about
                del left[receipt.number]
                yield receipt
            deaths += 1
            if deaths == PATIENCE:
                raise InputError(
                    f"{job.out}: expected workers that live, got {deaths} deaths in a row while shards "
                    f"{', '.join(map(str, list(left)[:workers]))} were made; is there enough memory?"
                ) from None


def _pooled(job: Job, shards: Sequence[int], workers: int) -> Generator[Receipt, None, None]:
    context = multiprocessing.get_context("spawn")
    with one_thread_each():
        pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin)
        waiting = iter(shards)
        pending: set[Future[Receipt]] = set()
        try:
            while True:
                for number in waiting:
                    pending.add(pool.submit(make_shard, job, number))
                    if len(pending) == 2 * workers:  # a job in hand for each, and no list of a million
                        break
                if not pending:
                    break
                done, pending = wait(pending, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in done)
        except BaseException:
            _stop(pool)
            raise
        pool.shutdown()


def _stop(pool: ProcessPoolExecutor) -> None:
    """End the workers now; what they were writing has no name yet, and is gone or removed by the next run."""
    for process in list((pool._processes or {}).values()):
        process.terminate()
    pool.shutdown(wait=True, cancel_futures=True)


def _begin() -> None:
    """Leave Ctrl-C to the parent, and end with it, whatever ends it."""
    ignore_interrupts()
    parent = multiprocessing.parent_process()
    assert parent is not None

    def follow() -> None:
        wait_for([parent.sentinel])
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
