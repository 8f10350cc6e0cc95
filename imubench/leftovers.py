"""What is to be undone however a command ends: temporary files, locks, processes.

A context undoes what it did when its body ends. A signal can come in the instant in which a context is left and keep it
from that, so what is to be undone is noted as well, and the door of the command line does what is still noted.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

_noted: dict[object, Callable[[], object]] = {}


@contextmanager
def undone(undo: Callable[[], object]) -> Iterator[None]:
    """Call `undo` when the context ends, by an error or not; at the latest, `undo_all` does.

    It may be called twice, and must then do nothing.
    """
    key = object()
    _noted[key] = undo
    try:
        yield
    finally:
        undo()
        _noted.pop(key, None)


def undo_all() -> None:
    """Undo what is still noted, the latest first; what fails is left as it is."""
    while _noted:
        _, undo = _noted.popitem()
        with suppress(BaseException):
            undo()
