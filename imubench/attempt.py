"""What an estimator makes of a recording when nobody vouches for it: an estimate, or how it failed."""

import traceback
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import cache
from math import isfinite
from multiprocessing import get_context
from multiprocessing.util import Finalize

from imubench.entry_points import OURS, said
from imubench.errors import InputError
from imubench.estimate import AnswerError, Estimate, Failed
from imubench.estimators import Estimator
from imubench.leftovers import undone
from imubench.plugins import Outside
from imubench.recording import Recording
from imubench.workers import Pool, begin, one_thread_each


def attempted(
    estimator: Estimator, recording: Recording, seconds: float | None = None, apart: "Apart | None" = None
) -> Estimate | Failed:
    """Return what an estimator makes of a recording; whatever goes wrong in it is the answer, and no error.

    Args:
        estimator: any; one of `find_estimator`, or one that can be sent to another process, where `seconds` are given.
        recording: what it is given.
        seconds: s by the clock, from when it has been loaded; then it counts as hanging, and its process is killed.
            None: no limit, and no process of its own.
        apart: the process in which it runs, where many run with a limit one after the other; None: one for it alone.
    """
    if seconds is None:
        return _attempt(estimator, recording)
    if apart is not None:
        return apart.attempt(estimator, recording, seconds)
    with running_apart() as own:
        return own.attempt(estimator, recording, seconds)


class Apart:
    """A process in which estimators run one after the other; one that hangs or dies is replaced."""

    def __init__(self) -> None:
        self._pool: Pool | None = None

    def attempt(self, estimator: Estimator, recording: Recording, seconds: float) -> Estimate | Failed:
        """Return what an estimator makes of a recording within `seconds` s by the clock, as `attempted` does."""
        try:
            pool = self._begun()
            pool.submit(_unusable, estimator).result()  # what it imports is not its work
            return pool.submit(_attempt, estimator, recording).result(timeout=seconds)
        except TimeoutError:
            self.end()
            return Failed(estimator.name, "timed out", f"no answer after {seconds:g} s")
        except BrokenProcessPool:
            self.end()
            return Failed(estimator.name, "crashed", "its process died: a fault in compiled code, or memory was full")
        except Exception as error:  # it, or its answer, cannot be sent to the other process
            why = str(InputError(f"expected what another process can load, got {said(error)}"))
            return Failed(estimator.name, "malformed", why)

    def end(self) -> None:
        """End the process, if there is one; the next attempt begins another."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.end()

    def _begun(self) -> Pool:
        if self._pool is None:
            with one_thread_each():
                self._pool = Pool(1, mp_context=get_context("spawn"), initializer=begin)
                self._pool.submit(_unusable, None).result()
        return self._pool


@cache
def own_apart() -> Apart:
    """Return the process apart of this one, for all its attempts; it begins with the first of them.

    It ends before this process waits for its children, as one of a pool does at its end, and would for ever.
    """
    apart = Apart()
    Finalize(None, apart.end, exitpriority=0)
    return apart


@contextmanager
def running_apart() -> Iterator[Apart]:
    """Hand out a process for attempts with a limit; it begins with the first, and is killed when the context ends."""
    apart = Apart()
    with undone(apart.end):
        yield apart


def _unusable(estimator: Estimator | None) -> str | None:
    """Import what an estimator needs; return why that cannot be done, or None."""
    if estimator is not None and isinstance(estimator.estimate, Outside):
        try:
            estimator.estimate.load()
        except InputError as error:
            return str(error)
    return None


def _attempt(estimator: Estimator, recording: Recording) -> Estimate | Failed:
    broken = _unusable(estimator)
    if broken is not None:
        return Failed(estimator.name, "crashed", broken)
    try:
        return checked_answer(estimator.estimate(recording), estimator, recording)
    except AnswerError as error:
        return Failed(estimator.name, "malformed", str(error))
    except InputError as error:
        return Failed(estimator.name, "refused", str(error))
    except (Exception, SystemExit) as error:
        return Failed(estimator.name, "crashed", str(InputError(said(error))), _trace(error))


def checked_answer(answer: object, estimator: Estimator, recording: Recording) -> Estimate:
    """Return an answer that is an estimate of what its estimator is for, and of this recording.

    Raises:
        AnswerError: it is no `Estimate`; of another quantity than the estimator's; an axis of a rig that has none;
            not one row for each IMU; or a detail is no finite number.
    """
    name = estimator.name
    if not isinstance(answer, Estimate):
        raise AnswerError(f"{name}: expected an Estimate, got {type(answer).__name__}")
    if estimator.quantity is not None and answer.quantity != estimator.quantity:
        raise AnswerError(f"{name}: expected a {estimator.quantity}, as it declares, got a {answer.quantity}")
    tree = recording.tree
    if answer.quantity == "joint_axis" and tree.segments and tree.hinge is None:  # one's own rig may have an axis
        raise AnswerError(f"{name}: expected a joint_vector, as rig {recording.rig} has no axis, got a joint_axis")
    rows, imus = answer.value.shape[-2], len(recording.imus)
    if rows != imus:
        raise AnswerError(f"{name}.value: expected {imus} rows, one for each IMU, got {rows}")
    for key, value in answer.details.items():
        try:
            fine = isfinite(value)
        except (TypeError, OverflowError):
            fine = False
        if not fine or not isinstance(key, str):
            raise AnswerError(f"{name}.details: expected finite numbers by name, got {key!r}: {value!r}")
    return answer


def _trace(error: BaseException) -> str:
    """Return Python's trace of a stranger's error from where their code was called."""
    trace = error.__traceback__
    while trace is not None and trace.tb_frame.f_code.co_filename.startswith(OURS):
        trace = trace.tb_next
    return "".join(traceback.format_exception(type(error), error, trace))


__all__ = ["Apart", "Failed", "attempted", "checked_answer", "own_apart", "running_apart"]
