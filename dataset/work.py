"""What engines do: work that falls into numbered pieces, each of which follows from its number alone."""

from collections.abc import Mapping
from typing import Any, Protocol, TypeVar


class Numbered(Protocol):
    """What is left of a finished piece, small enough to be sent."""

    @property
    def number(self) -> int:
        """Its number."""


Piece = TypeVar("Piece", bound=Numbered, covariant=True)


class Work(Protocol[Piece]):
    """A dataclass that can be sent to every worker; whoever makes a piece, and when, it is the same to the bit."""

    @property
    def out(self) -> str:
        """Where its result is written: a folder or URL that every worker sees, if workers write."""

    def make(self, number: int) -> Piece:
        """Make a piece; `InputError` ends the whole work."""

    def finished(self, number: int) -> Piece | None:
        """Return a piece that a worker has finished and told nobody about; None where it is to be made again."""

    def identity(self) -> Mapping[str, Any]:
        """Return what decides about the bytes: a worker that has something else is refused."""
