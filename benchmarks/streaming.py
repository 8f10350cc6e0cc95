"""The streaming estimators: one update at any length of history, and samples per processor second.

Hinge axes get one second of sequence 1 of Olsson 2020 an update. `sliding-stream` gets the paper's pendulum, ten
seconds with each kind of r; the filter that takes gravity out counts.
"""

import time
from collections.abc import Callable

import numpy as np

from benchmarks.table import Row
from imubench.estimators import guarded, plug_and_play
from imubench.estimators.gravity import GravityUkf
from imubench.estimators.guarded import GuardedPlugAndPlay
from imubench.estimators.plug_and_play import PlugAndPlay, Update, batches
from imubench.estimators.sliding import SlidingStream
from imubench.paired import Paired, paired
from imubench.scenarios.olsson2020.sequences import assemble
from imubench.scenarios.pendulum import SoftTissue, ellipse, limb
from imubench.sim.play import play

LIMIT = 20.0  # ms, for one update
FASTEST = 2000  # samples per processor second of sliding-stream, twenty times real time at 100 Hz
SECONDS = 10.0  # s, of each of its recordings
NOISE = 0.0017, 0.02  # rad/s, m/s^2 per sample
KINDS: tuple[SoftTissue, ...] = ("none", "paper", "sliding", "sprung")
NAMES = ("constant", "unfelt", "felt", "spring")
EARLY, LATE = slice(100, 200), slice(-100, None)  # updates whose medians tell whether time grows with the history


def milliseconds(update: Callable[[Paired], Update], samples: Paired) -> list[float]:
    """Return the processor time in ms of every update over the recording; a busy machine so does not count."""
    took = []
    for batch in batches(samples):
        start = time.process_time()
        update(batch)
        took.append(1e3 * (time.process_time() - start))
    return took


def sliding_rates(rate: float, seeds: int = 3) -> dict[str, float]:
    """Return samples per processor second by kind of r, at `rate` Hz: the median over seeds."""
    rates = {}
    for kind in KINDS:
        truth = play(limb(kind, frequency=0.7), ellipse(), SECONDS, rate).sensors[0]
        took = []
        for seed in range(seeds):
            rng = np.random.default_rng(seed)
            gyro, accel = (
                x + std * rng.normal(size=x.shape)
                for x, std in zip((truth.gyro, truth.specific_force), NOISE, strict=True)
            )
            gravity, centre = GravityUkf(), SlidingStream(*NOISE)
            start = time.process_time()
            for w, f in zip(gyro, accel, strict=True):
                centre.update(w, f, gravity.update(w, f, 1 / rate), 1 / rate)
            took.append(time.process_time() - start)
        rates[kind] = len(truth.gyro) / float(np.median(took))
    return rates


def sliding_rows() -> list[Row]:
    """Return a row for each rate of sampling."""
    rows = []
    for rate in (50.0, 100.0, 200.0):
        rates = sliding_rates(rate)
        rows.append(
            Row(
                f"sliding-stream, gravity by the filter, {SECONDS:g} s at {rate:g} Hz: samples per processor second, "
                f"r {', '.join(NAMES)}",
                ", ".join(f"{x:,.0f}" for x in rates.values()),
                f"{rate:g} in real time",
                f"{min(rates.values()) / rate:.0f}",
                f">= {FASTEST:,}",
                min(rates.values()) >= FASTEST,
            )
        )
    return rows


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
    return rows + sliding_rows()
