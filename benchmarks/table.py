"""The rows of RESULTS.md."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One figure of ours beside a peer's, from the same run."""

    what: str
    ours: str
    peer: str
    ratio: str
    required: str
    met: bool
