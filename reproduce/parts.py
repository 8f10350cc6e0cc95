"""Parts of experiments on all cores, with what is finished kept on the disk, so that an interrupted run goes on.

Processes are spawned, not forked, with one thread of linear algebra each: two threads a process on two cores
would only get into each other's way. Workers ignore Ctrl-C; the parent stops handing out parts, and waits for
the few seconds that the running ones need.
"""

import hashlib
import json
import multiprocessing
import os
import shutil
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

import numpy as np

import imubench
from imubench.atomic import atomic_file
from imubench.reproduce.paper import Arrays, Part

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
COMPUTING = ("imubench.estimators", "imubench.models", "imubench.scenarios", "imubench.sim", "imubench.reproduce")

Report = Callable[[Part], None]
"""Called once for every part that is done."""


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Store:
    """Finished parts in a hidden folder beside the output; `forget` removes it."""

    def __init__(self, out: Path, settings: str):
        target = Path(out).resolve()
        self.home = target.parent / f".{target.name}.parts"
        self.folder = self.home / _key(settings)

    def load(self, part: Part) -> Arrays | None:
        """Return the arrays of a finished part, or None; a broken file counts as none."""
        path = self._path(part)
        if not path.exists():
            return None
        try:
            with np.load(path, allow_pickle=False) as stored:
                return {name: stored[name] for name in stored.files}
        except (OSError, ValueError, KeyError, EOFError):
            return None

    def save(self, part: Part, arrays: Mapping[str, object]) -> Arrays:
        """Keep the arrays of a finished part, and return them."""
        done = {name: np.asarray(value) for name, value in arrays.items()}
        with atomic_file(self._path(part)) as partial, partial.open("wb") as file:
            np.savez(file, **done)  # type: ignore[arg-type]
        return done

    def forget(self) -> None:
        """Remove all finished parts of this output."""
        shutil.rmtree(self.home, ignore_errors=True)

    def _path(self, part: Part) -> Path:
        return self.folder / f"{part.name}.npz"


def _key(settings: str) -> str:
    """Return a name that changes with the settings and with any line of code that computes."""
    digest = hashlib.sha256(f"{imubench.__version__} {np.__version__} {settings}".encode())
    for package in COMPUTING:
        for name, content in sorted(sources(files(package))):
            digest.update(f"{package}/{name}".encode() + content)
    return digest.hexdigest()[:16]


def sources(folder: Traversable) -> Iterator[tuple[str, bytes]]:
    """Yield the name and content of every file below a folder that decides about numbers."""
    for item in folder.iterdir():
        if item.is_dir():
            yield from ((f"{item.name}/{name}", content) for name, content in sources(item))
        elif item.name.endswith((".py", ".toml", ".xml")):
            yield item.name, item.read_bytes()


def run_parts(parts: Iterable[Part], store: Store, workers: int, report: Report) -> dict[str, Arrays]:
    """Return the arrays of every part by its name, from the store or computed and put there.

    On Ctrl-C the parts that are being computed are finished and kept before `KeyboardInterrupt` goes on.
    With `workers` = 0 everything happens in this process.
    """
    done: dict[str, Arrays] = {}
    open_parts = []
    for part in parts:
        stored = store.load(part)
        if stored is None:
            open_parts.append(part)
        else:
            done[part.name] = stored
            report(part)
    if workers == 0:
        for part in open_parts:
            done[part.name] = store.save(part, part.run(**part.arguments))
            report(part)
    elif open_parts:
        _compute(open_parts, store, workers, report, done)
    return done


def _compute(parts: list[Part], store: Store, workers: int, report: Report, done: dict[str, Arrays]) -> None:
    context = multiprocessing.get_context("spawn")
    with (
        one_thread_each(),
        ProcessPoolExecutor(min(workers, len(parts)), mp_context=context, initializer=ignore_interrupts) as pool,
    ):
        # The longest first, so that no core waits long at the end.
        pending = {pool.submit(p.run, **p.arguments): p for p in sorted(parts, key=lambda p: -p.work)}

        def collect(finished: Iterable[Future[Mapping[str, object]]]) -> None:
            for future in finished:
                part = pending.pop(future)
                done[part.name] = store.save(part, future.result())
                report(part)

        try:
            while pending:
                collect(wait(pending, return_when=FIRST_COMPLETED)[0])
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            with suppress(Exception):
                collect([f for f in list(pending) if f.done() and not f.cancelled() and f.exception() is None])
            raise


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


def ignore_interrupts() -> None:
    """Have this process leave Ctrl-C to the one that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def settings_text(settings: object, quick: bool) -> str:
    """Return settings as text that is the same for the same settings."""
    return json.dumps([quick, repr(settings)])
