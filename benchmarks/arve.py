"""The joint centre filters beside the paper's time for one ArVE_d sample: one at a time, and 100 runs side by side."""

import time
from functools import partial

import numpy as np

from benchmarks.pendulum_runs import R_VARIES, Runs, circling
from benchmarks.table import Row
from imubench.estimators.arve import Arve
from imubench.estimators.arve_d import ArveD
from imubench.estimators.centre_ekf import CentreFilter, covariances_of
from imubench.estimators.centre_runs import track
from imubench.estimators.gravity import GravityUkf

PAPER = 30.0  # us for one sample of ArVE_d in MATLAB R2019b on an i7-8700 at 3.2 GHz (section V-C)
SIDE_BY_SIDE = 3.0  # us per sample and run
RUNS = 100
REPEATS = 7


def streaming(centre: CentreFilter, runs: Runs) -> tuple[float, np.ndarray]:
    """Return the us of one sample once the filter runs, and every r from then on (n, 3)."""
    samples = list(zip(runs.gyro[0], runs.acceleration[0], strict=True))
    for w, a in samples[: centre.initial_samples]:
        centre.update(w, a, 0.01)
    rest = samples[centre.initial_samples :]
    start = time.perf_counter()
    answers = [centre.update(w, a, 0.01) for w, a in rest]
    return 1e6 * (time.perf_counter() - start) / len(rest), np.array(answers)


def removing(runs: Runs) -> float:
    """Return the us of one sample of gravity removal by the unscented filter."""
    ukf = GravityUkf()
    start = time.perf_counter()
    for w, f in zip(runs.gyro[0], runs.accel[0], strict=True):
        ukf.update(w, f, 0.01)
    return 1e6 * (time.perf_counter() - start) / len(runs.time)


def run() -> list[Row]:
    """Return rows for both filters, each the least of seven, so that what else the machine does stays out."""
    runs = circling(np.random.default_rng(1), count=RUNS, amplitude=R_VARIES)
    rows = []
    for name, new, states in (("ArVE_d", ArveD, 12), ("ArVE", Arve, 9)):
        key = "arve-d" if states == 12 else "arve"
        one = [streaming(new(), runs) for _ in range(REPEATS)]
        alone = min(took for took, _ in one)
        all_runs = partial(track, runs.gyro, runs.acceleration, runs.time, states, covariances_of(key))
        took = []
        for _ in range(REPEATS):
            start = time.perf_counter()
            tracks = all_runs()
            took.append(1e6 * (time.perf_counter() - start) / tracks.r[..., 0].size)
        together = min(took)
        same = np.allclose(tracks.r[0, 1:], one[0][1], rtol=0, atol=1e-12)  # rounding
        rows += [
            Row(
                f"{name}, one sample streaming, beside the paper's MATLAB",
                f"{alone:.1f} us",
                f"{PAPER:.0f} us",
                f"{PAPER / alone:.1f}",
                f"<= {PAPER:.0f} us",
                alone <= PAPER,
            ),
            Row(
                f"{name}, {RUNS} runs side by side, a sample of a run" + (", same numbers" if same else ", NOT SAME"),
                f"{together:.2f} us",
                f"{alone:.1f} us, streaming",
                f"{alone / together:.1f}",
                f"< {SIDE_BY_SIDE:.0f} us",
                same and together < SIDE_BY_SIDE,
            ),
        ]
    ukf = min(removing(runs) for _ in range(REPEATS))
    rows.append(Row("gravity removal by the UKF, one sample streaming", f"{ukf:.0f} us", "-", "-", "-", True))
    return rows
