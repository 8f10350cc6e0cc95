"""Ctrl-C, SIGTERM and a closed terminal end a command in order: what is open is cleaned up, then one line is said."""

import signal
import time
from types import FrameType

HANDLED = ("SIGINT", "SIGTERM", "SIGHUP")
IMPATIENCE = 5.0  # s after which a further signal interrupts the cleaning up as well


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


def handle() -> None:
    """Have the signals raise `Stopped`, once; in the next seconds, while things are cleaned up, they are ignored."""
    raised = -IMPATIENCE

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal raised
        if time.monotonic() - raised >= IMPATIENCE:
            raised = time.monotonic()
            raise Stopped(number)

    for name in HANDLED:
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:  # nohup and & stay as they are
            signal.signal(number, stop)


def ignore() -> None:
    """Leave the signals alone from now on: the result is known, and only the interpreter has to end."""
    for name in HANDLED:
        number = getattr(signal, name, None)
        if number is not None:
            signal.signal(number, signal.SIG_IGN)
