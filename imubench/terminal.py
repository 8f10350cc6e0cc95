"""What is said to people: printable whatever it names, plain unless styled, and never a reason to lose a result."""

import os
import sys
from typing import Any, TextIO

from rich.console import Console
from rich.text import Text

from imubench.errors import InputError, printable


class Terminal(Console):
    """A console that takes text as it is: no markup in it, control characters shown."""

    def __init__(self, stderr: bool = False) -> None:
        super().__init__(stderr=stderr, markup=False, highlight=False, emoji=False)

    def render_str(self, text: str, **options: Any) -> Text:
        """Return text with its control characters shown, but for line ends and tabs."""
        return super().render_str(shown_lines(text), **options)

    def say(self, text: str, style: str = "", then: str = "") -> None:
        """Print one line, as long as it is; `style` is that of `text` alone."""
        self.print(Text.assemble((shown_lines(text), style), shown_lines(then)), soft_wrap=True)


def shown_lines(text: str) -> str:
    """Return text whose control characters are shown, but for line ends and tabs."""
    return text if text.isprintable() else "".join(c if c in "\n\t" else printable(c) for c in text)


class Output:
    """A standard stream whose reader may go away: what nobody reads is dropped, and the work goes on."""

    def __init__(self, stream: TextIO, name: str) -> None:
        self._stream, self._name = stream, name

    def write(self, text: str) -> int:
        """Write text; `InputError` where the stream takes none, such as a file on a full disk."""
        try:
            return self._stream.write(text)
        except OSError as error:
            self._failed(error)
            return len(text)

    def flush(self) -> None:
        """Hand on what was written; `InputError` as `write`."""
        try:
            self._stream.flush()
        except OSError as error:
            self._failed(error)

    def _failed(self, error: OSError) -> None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())  # so that what is buffered can be let go at the end
        os.close(nowhere)
        if not isinstance(error, BrokenPipeError):
            raise InputError(f"{self._name}: expected a place that can be written, got: {error.strerror}") from None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def guard_streams() -> None:
    """Make the standard streams of this process ones that no reader and no character can break."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed by whoever started us
            stream = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123  # for as long as we run
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
        setattr(sys, name, Output(stream, f"standard {'output' if name == 'stdout' else 'error'}"))
