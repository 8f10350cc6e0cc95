"""What the recordings of a cell say together: a quantile with its interval, and how often there is no answer."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.sweeps.intervals import quantile, quantile_interval, share_interval
from imubench.sweeps.spec import Sweep
from imubench.sweeps.work import ANSWERED, UNPLAYED, Outcome
from imubench.units import SHOWN

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


@dataclass(frozen=True)
class Cell:
    """One estimator in one cell; errors in deg or mm.

    A recording that was played and has no answer counts as an infinite error: no estimator gets better by being silent
    where it is hard. One that cannot be played counts as none.
    """

    at: tuple[int, int]
    estimator: str
    recordings: int
    played: int
    outcomes: Mapping[str, int]  # how often each, of those played
    best_pairing: int  # of those played: judged by the better of two sign pairings
    errors: Array  # (played,) in the order of the recordings; inf where there is no answer
    value: float  # the quantile that the sweep shows; NaN where nothing was played
    bound: float  # the same where a recording that cannot be played counts as an infinite error
    interval: tuple[float, float]  # of the value
    whys: tuple[str, ...]  # why there was no answer or nothing to play, each once

    @property
    def failed(self) -> int:
        """How many recordings were played and have no answer."""
        return sum(n for outcome, n in self.outcomes.items() if outcome not in ANSWERED)

    @property
    def failed_interval(self) -> tuple[float, float]:
        """The interval of the share of them."""
        return share_interval(self.failed, self.played)

    def quantiles(self) -> list[float]:
        """Return the `QUANTILES` of the errors."""
        return [quantile(self.errors, q) for q in QUANTILES]


@dataclass(frozen=True)
class Map:
    """One estimator over the grid: arrays (a, b), b = 1 where there is one axis."""

    estimator: str
    value: Array  # deg or mm; inf: mostly no answer; NaN: nothing was played
    bound: Array  # the same, with recordings that cannot be played as infinite errors
    low: Array
    high: Array
    played: Array  # share of the recordings
    failed: Array  # share of those played
    best_pairing: bool  # any error is that of the better of two sign pairings

    def below(self, limit: float) -> NDArray[np.bool_]:
        """Return where (a, b) the error is at most the limit, however large it is where nothing can be played."""
        return np.asarray(self.bound <= limit)


def cells(sweep: Sweep, estimators: Sequence[str], outcomes: Iterable[Outcome]) -> list[Cell]:
    """Return every cell of every estimator, in the order of the grid and then of the estimators."""
    found: dict[tuple[tuple[int, int], str], list[Outcome]] = {}
    for o in outcomes:
        found.setdefault((o.cell, o.estimator), []).append(o)
    a, b = sweep.shape
    return [_cell(sweep, found[(i, j), e], e) for i in range(a) for j in range(b) for e in estimators]


def _cell(sweep: Sweep, outcomes: list[Outcome], estimator: str) -> Cell:
    outcomes = sorted(outcomes, key=lambda o: o.recording)
    played = [o for o in outcomes if o.outcome != UNPLAYED]
    factor = SHOWN[sweep.score_unit][1]
    errors = np.array([np.inf if o.error is None else factor * o.error for o in played])
    return Cell(
        outcomes[0].cell,
        estimator,
        len(outcomes),
        len(played),
        dict(Counter(o.outcome for o in played)),
        sum(o.best_pairing for o in played),
        errors,
        quantile(errors, sweep.quantile),
        quantile(np.append(errors, np.full(len(outcomes) - len(played), np.inf)), sweep.quantile),
        quantile_interval(errors, sweep.quantile),
        tuple(dict.fromkeys(o.why for o in outcomes if o.why)),
    )


def maps(sweep: Sweep, estimators: Sequence[str], found: Sequence[Cell]) -> list[Map]:
    """Return one map an estimator."""

    def grid(of: list[float]) -> Array:
        return np.array(of, dtype=float).reshape(sweep.shape)

    drawn = []
    for name in estimators:
        own = [cell for cell in found if cell.estimator == name]
        drawn.append(
            Map(
                name,
                grid([c.value for c in own]),
                grid([c.bound for c in own]),
                grid([c.interval[0] for c in own]),
                grid([c.interval[1] for c in own]),
                grid([c.played / c.recordings for c in own]),
                grid([c.failed / max(c.played, 1) for c in own]),
                any(c.best_pairing for c in own),
            )
        )
    return drawn
