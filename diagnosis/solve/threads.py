"""Two cores' work: the fit multiplies thousands of small matrices, on which BLAS threads only wait for each other.

They go to threads by the hundred, with one BLAS thread each.
"""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from functools import cache, wraps
from threading import current_thread
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

from imubench.diagnosis.budget import check
from imubench.diagnosis.config.solve import ALGEBRA

P = ParamSpec("P")
S = TypeVar("S")
T = TypeVar("T")


def _cores() -> int:
    """Return how many cores there are for this process, no more than it was told to use for linear algebra."""
    here = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    told = os.environ.get("OMP_NUM_THREADS", "")
    return min(here, int(told)) if told.isdigit() else here


CORES = min(2, _cores())
NAME = "rows"


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


def one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Return the function run with one BLAS thread; on a busy machine ten times faster than with two."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> T:
        with _controller().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@cache
def _pool(process: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(CORES, thread_name_prefix=NAME)


def side_by_side(function: Callable[[S], T], items: Iterable[S], knots: int = 0) -> Iterator[T]:
    """Yield what a function makes of items, in their order, a few of them made while the last is looked at.

    One after the other where each is a fit of so many `knots` that two at once would take too much memory. Work that is
    one of several such pieces already does its own pieces itself: its threads would wait for each other. Before each
    the time limit is asked.
    """

    def asked(item: S) -> T:
        check()
        return function(item)

    if CORES < 2 or knots > ALGEBRA.knots_beside or current_thread().name.startswith(NAME):
        yield from map(asked, items)
        return
    pool = _pool(os.getpid())  # threads do not survive a fork
    under_way: deque[Future[T]] = deque()
    try:
        for item in items:
            under_way.append(pool.submit(copy_context().run, asked, item))
            if len(under_way) > CORES:
                yield under_way.popleft().result()
        while under_way:
            yield under_way.popleft().result()
    finally:  # interrupted, or one has failed: what has not begun is not begun
        for piece in under_way:
            piece.cancel()
