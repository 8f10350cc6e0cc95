"""What a reader is to the fuzzer: a valid input, the file in it that is broken, and what a command does with it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from fuzz.mutate import Mutate
from fuzz.seeds import Files


@dataclass(frozen=True)
class Reader:
    """One file, or list of options, that a command takes in.

    `read(folder, out)` goes the way of the command without what follows reading; `out` is a path where nothing is.
    `words(folder, out)` are the command's words: every so many inputs the whole command is run in the same process.
    """

    name: str
    target: str  # the file that is broken, relative to the input's folder
    files: Callable[[], Files]  # a valid input
    mutate: Mutate
    read: Callable[[Path, Path], object]
    words: Callable[[Path, Path], list[str]] | None = None
    long: Callable[[Path], bool] | None = None  # whether a valid input asks for more work than a fuzzer waits for
    every: int = 20  # inputs to a whole command, which takes longer than its reader
    writes: Literal["nothing", "when accepted", "always"] = "nothing"  # in the input's folder
    leads_outside: bool = False  # whether its user may name a file anywhere: a path on the command line
    as_text: bool = False  # whether its content is handed over as text, so that nothing can stand in a file's place
    refuses: str = ""  # why its command refuses even the valid input

    def with_target(self, content: bytes) -> Files:
        """Return the valid input with another content of its target."""
        return {**self.files(), self.target: content}
