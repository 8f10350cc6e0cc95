"""What a paper is to `imubench reproduce`: experiments cut into parts, figures and tables, claims."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from imubench.arrays import Array
from imubench.recording import Recording
from imubench.reproduce.claims import Claim, Measured
from imubench.truth import Truth

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

Arrays = dict[str, Array]


@dataclass(frozen=True)
class Part:
    """A piece of an experiment, some seconds of work in a process of its own."""

    name: str  # unique in its paper, a file name
    stage: str  # what is going on, as a user wants to read it
    work: float  # seconds expected, only to pace the progress bar
    run: Callable[..., Mapping[str, Any]]  # returns arrays by name; importable by a fresh process
    arguments: Mapping[str, Any]


@dataclass(frozen=True)
class Trial:
    """A recording of a paper, with its truth, that any estimator can be given whole."""

    name: str  # as people read it
    play: Callable[..., tuple[Recording, Truth]]  # importable by a fresh process
    arguments: Mapping[str, Any]


@dataclass(frozen=True)
class Figure:
    """A plot that says what it shows."""

    name: str  # file name and anchor
    label: str  # "Figure 5"
    finding: str  # one sentence
    text: str  # what is drawn, and what to compare it with in the paper
    draw: Callable[[], "Drawing"]


@dataclass(frozen=True)
class Table:
    """Numbers beside published ones."""

    name: str
    label: str
    finding: str
    text: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Story:
    """What the report tells beside the claims."""

    setting: str  # what was simulated and how, a paragraph for a stranger
    exhibits: tuple[Figure | Table, ...]  # in the order of the paper
    notes: tuple[str, ...] = ()  # readings taken, limits


@dataclass(frozen=True)
class Paper:
    """A paper that can be reproduced.

    `settings(quick, seed)` gives the paper's own object S, `parts(S)` what is to be computed, `gather(S, done)`
    the results R from the arrays of all parts by name; every measure is a function of R, and so is the story.
    """

    name: str
    summary: str  # one line
    citation: str
    claims: tuple[Claim, ...]
    measures: Mapping[str, Callable[[Any], Measured]]
    settings: Callable[[bool, int], Any]
    parts: Callable[[Any], list[Part]]
    gather: Callable[[Any, Mapping[str, Arrays]], Any]
    tell: Callable[[Any], Story]
    links: Mapping[str, str] = field(default_factory=dict)  # text -> address
    method: str = ""  # the estimator of ours that is the paper's; empty where no other can stand beside it
    trials: Callable[[Any], Sequence[Trial]] = lambda _: ()  # its recordings, for estimators that a user names
