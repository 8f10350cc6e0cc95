"""Processes that work for a command: one thread of linear algebra each, and none outlives it, whatever ends it.

Processes are spawned, not forked. Workers ignore Ctrl-C and leave it to the command, which ends them at once; when the
command itself is killed they end by themselves.
"""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import wait
from time import monotonic, sleep
from typing import Any

from imubench.errors import InputError
from imubench.leftovers import undone
from imubench.signals import HANDLED

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
LEAKED = "ignore:resource_tracker:UserWarning"  # workers are killed, and leave theirs
PATIENCE = 1.0  # s in which a pool's thread drops what was cancelled; it takes milliseconds
DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux's prctl


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class WorkerError(InputError):
    """A worker was killed, most often because the memory was full."""


class Pool(ProcessPoolExecutor):
    """Processes that are started with the signals blocked: `begin` unblocks them, with nothing lost in between."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        _start_tracker()  # a pool's first semaphore would start it
        super().__init__(*arguments, **options)

    def _spawn_process(self) -> None:
        with _blocked():
            super()._spawn_process()  # type: ignore[misc]

    def end(self) -> None:
        """Kill the processes and drop what they do; nothing where they have ended.

        What was cancelled is dropped first: the pool's thread would try to fail it, and raise, when it finds its
        processes dead.
        """
        processes = list((self._processes or {}).values())
        thread: Any = self._executor_manager_thread
        self.shutdown(wait=False, cancel_futures=True)
        end = monotonic() + PATIENCE
        while thread is not None and self._cancel_pending_futures and thread.is_alive() and monotonic() < end:
            sleep(0.001)
        for process in processes:
            process.kill()
        if thread is not None:
            thread.join()


@contextmanager
def process_pool(workers: int) -> Iterator[Pool]:
    """Hand out a pool of processes; when its context ends by an error they are killed, and what they did is dropped.

    Raises:
        WorkerError: a process was killed by somebody else.
    """
    with one_thread_each():
        pool = Pool(workers, mp_context=multiprocessing.get_context("spawn"), initializer=begin)
        with undone(pool.end):
            try:
                yield pool
                pool.shutdown()
            except BrokenProcessPool:
                raise WorkerError(
                    "expected workers that live, got one that was killed; is there enough memory?"
                ) from None


@contextmanager
def _blocked() -> Iterator[None]:
    """Keep the signals that end a command from this thread, and from processes that it starts, for a moment."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [getattr(signal, name) for name in HANDLED])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_tracker() -> None:
    """Start the process that removes semaphores of processes that were killed, without what it would say of them.

    It unblocks signals when it starts, so it has to be there before they are blocked. Windows has none.
    """
    if sys.platform == "win32":
        return
    from multiprocessing import resource_tracker

    sys.warnoptions.append(LEAKED)  # handed to what this interpreter starts
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions.remove(LEAKED)


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Have processes that start within this context use one thread for linear algebra."""
    with environment(dict.fromkeys(THREADS, "1")):
        yield


@contextmanager
def environment(values: Mapping[str, str]) -> Iterator[None]:
    """Have processes that start within this context find these values in their environment."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
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
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [getattr(signal, name) for name in HANDLED])
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
