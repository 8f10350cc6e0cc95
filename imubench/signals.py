"""Ctrl-C, SIGTERM and a closed terminal end a command in order: what is open is cleaned up, then one line is said.

A signal raises `Stopped` where the program is. Python drops an exception that is raised while an object is deleted or
inside a callback from C, and extension modules may turn it into one of their own. So a watch looks whether `Stopped` is
still on its way, and raises it again where it is not; and what ends a command after a signal was ended by the signal.
"""

import _thread
import signal
import sys
import threading
import time
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

HANDLED = ("SIGINT", "SIGTERM", "SIGHUP")
IMPATIENCE = 5.0  # s after which a further signal interrupts the cleaning up as well
WATCH = 0.1  # s between two looks whether `Stopped` was dropped: soon for a person, seldom for a processor


class Stopped(BaseException):
    """A signal has come that ends the command; like `KeyboardInterrupt`, no `except Exception` holds it."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number

    @property
    def code(self) -> int:
        """The exit code: 130 after Ctrl-C, 143 after SIGTERM."""
        return 128 + self.number


STOPS = (Stopped, KeyboardInterrupt)
"""What ends a command from outside, with our handlers or without."""


class _Came:
    """The signal that has come, and its exception as long as that is on its way."""

    number: int | None = None
    at = 0.0  # s, of `time.monotonic`
    raised: weakref.ref[Stopped] | None = None
    over = False  # the command has ended
    promise = ""  # what is said of a command that is stopped just now


def handle() -> None:
    """Have the signals raise `Stopped`, once; in the next seconds, while things are cleaned up, they are ignored."""
    _Came.number, _Came.raised, _Came.over, _Came.promise = None, None, False, ""
    for name in HANDLED:
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:  # nohup and & stay as they are
            signal.signal(number, _stop)
    shown = sys.unraisablehook
    sys.unraisablehook = lambda dropped: None if came() is not None else shown(dropped)


def came() -> int | None:
    """Return the exit code of the signal that has come; None as long as none has."""
    return None if _Came.number is None else 128 + _Came.number


@contextmanager
def promising(what: str) -> Iterator[None]:
    """Have the command's last line say `what` where a signal comes within the context."""
    _Came.promise = what
    yield
    _Came.promise = ""  # not where it was stopped: the line is still to be said


def promised() -> str:
    """Return what the last line is to say of a command that a signal has stopped."""
    return _Came.promise


def ignore() -> None:
    """Leave the signals alone from now on: how the command ends is known, and what is left is to clean up and go."""
    _Came.over = True
    for name in HANDLED:
        number = getattr(signal, name, None)
        if number is not None:
            signal.signal(number, signal.SIG_IGN)


def _stop(number: int, frame: FrameType | None) -> None:
    first = _Came.number is None
    if not first and not _dropped() and time.monotonic() - _Came.at < IMPATIENCE:
        return
    if first:
        _Came.number = number
        _thread.start_new_thread(_watch, ())  # takes no lock that the program may hold just now
    _Came.at = time.monotonic()
    error = Stopped(_Came.number or number)
    _Came.raised = weakref.ref(error)
    try:
        raise error
    finally:
        del error  # or this frame, which its traceback holds, would keep it


def _dropped() -> bool:
    """Return whether the exception is gone, and the command is not over."""
    return not _Came.over and _Came.raised is not None and _Came.raised() is None


def _watch() -> None:
    while not _Came.over:
        time.sleep(WATCH)
        if _dropped() and _Came.number is not None:
            if hasattr(signal, "pthread_kill"):
                signal.pthread_kill(threading.main_thread().ident or 0, _Came.number)  # wakes it up as well
            else:
                _thread.interrupt_main(signal.Signals(_Came.number))
