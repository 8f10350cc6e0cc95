"""Ray makes the pieces: a task each, on the nodes of a cluster that see the place written to and have this software."""

import logging
import socket
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

from imubench.dataset.work import Piece, Work
from imubench.errors import InputError, first_line

RETRIES = 3  # of a piece whose worker or node died
KNOCK = 10.0  # s, for a cluster to answer
FAREWELL = 10.0  # s, for workers to end


def check(workers: int | None, address: str | None) -> None:
    """Raise `InputError` where there is no Ray, or no worker."""
    if workers == 0:
        raise InputError("workers: expected 1 or more with the engine ray, got 0")
    _ray()


def run(
    work: Work[Piece], numbers: Sequence[int], workers: int | None, address: str | None
) -> Generator[Piece, None, None]:
    """Yield each piece; `workers` bounds the tasks at a time, None: all cores of the cluster.

    `address` None: the cluster of RAY_ADDRESS or of this machine, else one that is started here for this run.
    """
    ray = _ray()
    if "://" not in work.out:
        # Workers stand in folders of their own.
        work = replace(work, out=str(Path(work.out).resolve()))  # type: ignore[type-var]
    with _connected(ray, address):
        task = ray.remote(num_cpus=1, max_retries=RETRIES)(_make)
        shared, expected = ray.put(work), work.identity()
        waiting = iter(numbers)
        pending: set[Any] = set()
        try:
            while True:
                most = workers or max(2, 2 * int(ray.cluster_resources().get("CPU", 0)))  # one in hand for each
                pending |= {task.remote(shared, expected, n) for n in islice(waiting, max(0, most - len(pending)))}
                if not pending:
                    break
                done, _ = ray.wait(list(pending), num_returns=1)
                pending -= set(done)
                for reference in done:
                    yield _made(ray, reference, work)
        finally:
            for reference in pending:
                with suppress(Exception):
                    ray.cancel(reference, force=True)
            if pending:
                with suppress(Exception):
                    ray.wait(list(pending), num_returns=len(pending), timeout=FAREWELL)


def _make(work: Work[Piece], expected: Mapping[str, Any], number: int) -> Piece:
    """Make a piece on a node, if that has what the caller has: else the bytes may differ."""
    found = work.identity()
    for key, wanted in expected.items():
        if found[key] != wanted:
            raise InputError(f"ray: expected nodes with the {key} of this one, {wanted}, got {found[key]}")
    return work.make(number)


def _made(ray: Any, reference: Any, work: Work[Piece]) -> Piece:
    try:
        piece: Piece = ray.get(reference)
        return piece
    except ray.exceptions.RayTaskError as error:
        if isinstance(error.cause, InputError):
            raise error.cause from None
        raise
    except ray.exceptions.RayError as error:
        line = first_line(error)
        raise InputError(
            f"{work.out}: expected workers that live, got {RETRIES + 1} deaths with one piece; is there enough memory, "
            f"and imubench on every node? The last said: {line}"
        ) from None


@contextmanager
def _connected(ray: Any, address: str | None) -> Iterator[None]:
    """Be a driver of the cluster; leave one that was there before as it was."""
    if ray.is_initialized():
        yield
        return
    _knock(address)
    try:
        ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
    except (ConnectionError, ValueError, RuntimeError) as error:
        line = first_line(error)
        raise InputError(f"address: expected that of a Ray cluster, got '{address}': {line}") from None
    try:
        yield
    finally:
        ray.shutdown()


def _knock(address: str | None) -> None:
    """Raise `InputError` where nobody answers at host:port; Ray itself would wait for minutes."""
    host, _, port = (address or "").removeprefix("ray://").rpartition(":")
    if not host or not port.isdecimal():
        return
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=KNOCK).close()
    except (OSError, OverflowError) as error:
        raise InputError(f"address: expected that of a Ray cluster, got '{address}': {error}") from None


def _ray() -> Any:
    try:
        import ray
    except ImportError:
        raise InputError("engine ray: expected Ray, got none; install it with: pip install 'imubench[ray]'") from None
    return ray
