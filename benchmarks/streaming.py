"""One update of one second of data, by length of the history: the streaming estimators on sequence 1 of Olsson 2020."""

import statistics
import time
from collections.abc import Callable

import numpy as np

from benchmarks.table import Row
from imubench.estimators.guarded import GuardedPlugAndPlay
from imubench.estimators.plug_and_play import PlugAndPlay, Update, batches
from imubench.paired import Paired, paired
from imubench.scenarios.olsson2020.sequences import assemble

LIMIT = 0.020  # s, for one update
HISTORIES = 10, 100, 700  # s
AROUND = 10  # updates before and at each, for a median


def seconds(update: Callable[[Paired], Update], samples: Paired) -> list[float]:
    """Return the seconds of every update over the recording."""
    took = []
    for batch in batches(samples):
        start = time.perf_counter()
        update(batch)
        took.append(time.perf_counter() - start)
    return took


def run() -> list[Row]:
    """Return a row for each estimator."""
    samples = paired(assemble("sequence1", seed=1).recording)
    rows = []
    for name, stream in (
        ("olsson2020-plug-and-play", PlugAndPlay(rng=np.random.default_rng(1))),
        ("olsson2020-guarded", GuardedPlugAndPlay(rng=np.random.default_rng(1))),
    ):
        took = seconds(stream.update, samples)
        medians = [1e3 * statistics.median(took[at - AROUND : at]) for at in HISTORIES]
        late = 1e3 * float(np.quantile(took, 0.99))
        ours = ", ".join(f"{m:.1f} ms at {at} s" for m, at in zip(medians, HISTORIES, strict=True))
        what = f"{name}: one update of 1 s of data (50 Hz, N_max 1000), median of {AROUND}; 99 % below {late:.1f} ms"
        rows.append(Row(what, ours, "-", "-", "< 20 ms", max(medians) < 1e3 * LIMIT and late < 1e3 * LIMIT))
    return rows


if __name__ == "__main__":
    for row in run():
        print(f"{row.what}\n    {row.ours} | required {row.required}: {'met' if row.met else 'MISSED'}")
