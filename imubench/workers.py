"""Processes that work for a command: one thread of linear algebra each, and none outlives it, whatever ends it.

Processes are spawned, not forked. Workers ignore Ctrl-C and leave it to the command, which ends them at once; when the
command itself is killed they end by themselves.
"""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux's prctl


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def process_pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Hand out a pool of processes; when its context ends by an error they are killed, and what they did is dropped."""
    context = multiprocessing.get_context("spawn")
    with one_thread_each():
        pool = ProcessPoolExecutor(workers, mp_context=context, initializer=begin)
        try:
            yield pool
        except BaseException:
            for process in list((pool._processes or {}).values()):
                process.kill()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
        pool.shutdown()


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Have processes that start within this context use one thread for linear algebra."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def begin() -> None:
    """Leave Ctrl-C to the process that started this one, and end with it."""
    ignore_interrupts()
    follow_parent()


def ignore_interrupts() -> None:
    """Have this process leave Ctrl-C to the one that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def follow_parent() -> None:
    """Have this process, which `multiprocessing` started, end when the one that started it has ended."""
    bind = die_with_parent()
    if bind is not None:
        bind()
    parent = multiprocessing.parent_process()
    assert parent is not None

    def follow() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


def die_with_parent() -> Callable[[], object] | None:
    """Return a function by which Linux kills the calling process when the thread that started it ends; None elsewhere.

    A process stays so when it becomes another program, so the function may be called between fork and start; what it
    needs is loaded before it is handed out.
    """
    if sys.platform != "linux":
        return None
    import ctypes

    try:
        prctl = ctypes.CDLL(None).prctl
    except (OSError, AttributeError):  # another C library
        return None
    return lambda: prctl(DEATH_SIGNAL, signal.SIGKILL)
