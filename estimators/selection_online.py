"""Sample selection while samples arrive: Olsson 2020, section 5.3.

Scores are saved; only new samples are scored, and those within half a window of the last one, whose windows
were not complete. Algorithm 2 so gives what it gives on all samples. Algorithm 3 does not, see `OnlineSelection`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from imubench.arrays import Array
from imubench.errors import unknown
from imubench.estimators.selection import Selected, Settings, four
from imubench.estimators.selection_accel import ENERGY_THRESHOLD, thin, window_penalties
from imubench.estimators.selection_gyro import (
    HALF_WIDTH,
    Index,
    gyro_scores,
    pick_gyro,
    rate_differences,
    squared_norms,
)

MEMORIES = ("survivors", "all")


@dataclass(frozen=True)
class _Scored:
    """Samples with a score or a penalty each, in the order of time."""

    ids: Index  # (m,)
    score: Array  # (m,)
    rows: Array  # (m, 6) of both sensors

    def __getitem__(self, which: slice | Index | NDArray[np.bool_]) -> "_Scored":
        return _Scored(self.ids[which], self.score[which], self.rows[which])

    def __add__(self, later: "_Scored") -> "_Scored":
        ids = np.concatenate([self.ids, later.ids])
        return _Scored(ids, np.concatenate([self.score, later.score]), np.concatenate([self.rows, later.rows]))


class OnlineSelection:
    """Algorithms 2 and 3 over a stream: `update` takes the new samples and returns the selected ones of all so far.

    `memory` says what Algorithm 3 chooses from. "survivors": from what it kept last time and the new samples,
    so that memory and time are bounded and a sample once removed stays removed; how the stream is cut into
    batches then matters. "all": from all samples so far, with their saved penalties, as `select` would; memory
    and time grow. The two agree as long as no more than `n_max` samples are slow enough, and in the first update
    with more.
    """

    def __init__(
        self,
        n_max: int,
        half_width: int = HALF_WIDTH,
        threshold: float = ENERGY_THRESHOLD,
        form: str = "printed",
        memory: str = "survivors",
    ):
        if memory not in MEMORIES:
            raise unknown("memory", memory, MEMORIES)
        self.settings, self.memory = Settings(n_max, half_width, threshold, form), memory
        self.seen = 0  # samples so far
        self._last = np.empty((0, 12))  # the last 2 `half_width` samples
        none = _Scored(np.empty(0, dtype=np.intp), np.empty(0), np.empty((0, 6)))
        self._gyro, self._accel = none, none  # of samples with complete windows

    def update(self, gyro1: ArrayLike, gyro2: ArrayLike, accel1: ArrayLike, accel2: ArrayLike) -> Selected:
        """Take the next samples, gyro (n, 3) in rad/s and accel (n, 3) in m/s^2, and select anew.

        Raises `InputError` as `select` does; the stream is then as it was before.
        """
        gyro, accel, complete = self._score(np.hstack(four(gyro1, gyro2, accel1, accel2)))
        n_max = self.settings.n_max
        stored = self._gyro + gyro[:complete]
        self._gyro = stored[pick_gyro(stored.score, n_max)]
        offered = self._gyro + gyro[complete:]
        rates = offered[pick_gyro(offered.score, n_max)]
        forces = self._choose_accel(accel, complete)
        return Selected(
            rates.ids, forces.ids, rates.rows[:, :3], rates.rows[:, 3:], forces.rows[:, :3], -forces.rows[:, 3:]
        )

    def _score(self, new: Array) -> tuple[_Scored, _Scored, int]:
        """Score the samples whose scores were not final, and say how many of them now are."""
        n = self.settings.half_width
        window = np.vstack([self._last, new])
        first = self.seen - len(self._last)  # number of the first sample in `window`
        begin = max(0, self.seen - n) - first
        self.seen += len(new)
        complete = max(0, self.seen - n) - first - begin
        w1, w2 = window[:, :3], window[:, 3:6]
        ids = np.arange(first + begin, self.seen)
        differences = gyro_scores(rate_differences(w1, w2), n)[begin:]
        penalty = window_penalties(squared_norms(w1), squared_norms(w2), n)[begin:]
        late = window[begin:]
        self._last = window[max(0, len(window) - 2 * n) :]
        accel = _Scored(ids, penalty, np.hstack([late[:, 6:9], -late[:, 9:]]))
        return _Scored(ids, differences, late[:, :6]), accel, complete

    def _choose_accel(self, new: _Scored, complete: int) -> _Scored:
        """Run Algorithm 3; it starts to remove once more than `n_max` samples have been seen, whatever is left."""
        s = self.settings
        stored = self._accel + new[:complete]
        if self.seen <= s.n_max:
            self._accel = stored
            return stored + new[complete:]
        stored = stored[stored.score <= s.threshold]
        chosen = stored[thin(stored.rows, stored.score, s.n_max, s.form)]
        self._accel = chosen if self.memory == "survivors" else stored
        return chosen
