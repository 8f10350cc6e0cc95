"""The work of a sweep: a piece is one recording of a row of cells, played, estimated and scored."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from imubench.attempt import Failed
from imubench.dataset.identity import COMPUTING as PLAYING
from imubench.dataset.identity import DECIDING, computed_by, hashes, rigs_of
from imubench.dataset.playing import Made, make
from imubench.errors import InputError
from imubench.figures import value_of
from imubench.plugin_versions import loaded, versions
from imubench.score import score
from imubench.sweeps.attempts import attempt, why
from imubench.sweeps.outside import peers
from imubench.sweeps.spec import Sweep, parse_sweep

COMPUTING = (
    *PLAYING,
    "imubench",
    "imubench.estimators",
    "imubench.sweeps",
)  # "imubench": what scores, and what all stand on
UNPLAYED = "not played"
ANSWERED = ("converged", "not converged", "not identifiable")


@dataclass(frozen=True)
class Outcome:
    """What became of one estimator on one recording of a cell."""

    cell: tuple[int, int]
    recording: int
    estimator: str
    outcome: str  # the estimate's status; how it failed; or `not played`
    error: float | None  # SI; None where there is none
    best_pairing: bool  # the error is that of the better of two sign pairings
    why: str  # a line, where there is no error


@dataclass(frozen=True)
class Piece:
    """What a finished piece came to."""

    number: int
    outcomes: tuple[Outcome, ...]


@dataclass(frozen=True)
class SweepWork:
    """A sweep with its estimators and its seed, small enough to be sent to every worker."""

    content: Mapping[str, bytes] = field(repr=False)
    recordings: int
    estimators: Mapping[str, str]  # as asked for -> as found from any folder
    prints: Mapping[str, str]  # as asked for -> what tells its version
    figure: str
    seconds: float  # that an estimate may take
    seed: int
    out: str  # for messages

    @property
    def sweep(self) -> Sweep:
        """The sweep, checked; read once a process."""
        return _sweep(tuple(sorted(self.content.items())), self.recordings)

    @property
    def pieces(self) -> int:
        """How many pieces there are: a recording of every row of cells."""
        return self.recordings * self.sweep.shape[1]

    def make(self, number: int) -> Piece:
        """Make a piece: recording k of every cell of a row, all estimators on each."""
        row, recording = number % self.sweep.shape[1], number // self.sweep.shape[1]
        outcomes: list[Outcome] = []
        with threadpool_limits(1):
            for i in range(self.sweep.shape[0]):
                outcomes += self._cell((i, row), recording)
        return Piece(number, tuple(outcomes))

    def finished(self, number: int) -> Piece | None:
        """Return None: pieces are kept by whoever asked for them."""
        return None

    def identity(self) -> dict[str, Any]:
        """Return what decides about the result."""
        return {
            "spec": hashes(self.content),
            **rigs_of(self.sweep.cell(0, 0)),
            "recordings": self.recordings,
            "seed": self.seed,
            "figure": self.figure,
            "seconds": self.seconds,
            "estimators": versions(self.estimators),
            "peers": peers(),
            **computed_by(COMPUTING, DECIDING),
        }

    def _cell(self, cell: tuple[int, int], recording: int) -> list[Outcome]:
        try:
            made = make(self.sweep.cell(*cell), self.seed, recording)
        except InputError as error:  # springs that do not hold a sensor, numbers drawn that make no rig
            return [Outcome(cell, recording, e, UNPLAYED, None, False, str(error)) for e in self.estimators]
        return [Outcome(cell, recording, name, *self._judged(name, made)) for name in self.estimators]

    def _judged(self, name: str, made: Made) -> tuple[str, float | None, bool, str]:
        method = loaded(name, self.estimators[name], self.prints[name])
        answer = attempt(method, made.recording, self.seconds)
        if isinstance(answer, Failed):
            return answer.status, None, False, why(answer)
        try:
            error, best = value_of(score(answer, made.truth), self.figure)
        except InputError as refused:
            return "malformed", None, False, str(refused)
        if error is None:
            return "malformed", None, False, f"expected a figure {self.figure}, got a {answer.quantity}"
        if not np.isfinite(error):
            return "malformed", None, False, f"expected a finite {self.figure}, got {error}"
        return answer.status, float(error), best, ""


@lru_cache(maxsize=2)
def _sweep(content: tuple[tuple[str, bytes], ...], recordings: int) -> Sweep:
    # The caller has checked the other cells.
    return parse_sweep(dict(content), recordings=recordings, every_cell=False)
