"""One update of one second of data at any length of history: the streaming estimators on sequence 1 of Olsson 2020."""

import time
from collections.abc import Callable

import numpy as np

from benchmarks.table import Row
from imubench.estimators import guarded, plug_and_play
from imubench.estimators.guarded import GuardedPlugAndPlay
from imubench.estimators.plug_and_play import PlugAndPlay, Update, batches
from imubench.paired import Paired, paired
from imubench.scenarios.olsson2020.sequences import assemble

LIMIT = 20.0  # ms, for one update
EARLY, LATE = slice(100, 200), slice(-100, None)  # updates whose medians tell whether time grows with the history


def milliseconds(update: Callable[[Paired], Update], samples: Paired) -> list[float]:
    """Return the processor time in ms of every update over the recording; a busy machine so does not count."""
    took = []
    for batch in batches(samples):
        start = time.process_time()
        update(batch)
        took.append(1e3 * (time.process_time() - start))
    return took


def run() -> list[Row]:
    """Return a row for each estimator."""
    samples = paired(assemble("sequence1", seed=1).recording)
    rows = []
    for name, stream in (
        (plug_and_play.NAME, PlugAndPlay(rng=np.random.default_rng(1))),
        (guarded.NAME, GuardedPlugAndPlay(rng=np.random.default_rng(1))),
    ):
        took = milliseconds(stream.update, samples)
        late = float(np.quantile(took, 0.99))
        growth = float(np.median(took[LATE]) / np.median(took[EARLY]))
        rows.append(
            Row(
                f"{name}, one update of 1 s of data (50 Hz, N_max 1000), processor time over {len(took)} s",
                f"{np.median(took):.1f} ms median, {late:.1f} ms at 99 %, {max(took):.1f} ms longest",
                "-",
                f"{growth:.1f}, the last 100 s to 100 to 200 s",
                "< 20 ms at 99 %",
                late < LIMIT,
            )
        )
    return rows
