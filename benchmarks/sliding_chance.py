"""`sliding` where frequency, phase, damping and noise are drawn: python -m benchmarks.sliding_chance [RUNS] [STREAMS]

Prints a table of docs/soft-tissue.md. Slides of 20 mm (x and z; 5 mm along y) at 0.3 to 5 Hz, evenly in the logarithm;
springs of 3 to 8 Hz with damping ratios from 0.05 to 0.5. The orientation is known. STREAMS of the runs are streamed.
"""

import sys

import numpy as np

from imubench.estimators import sliding
from imubench.estimators.centre_ekf import covariances_of
from imubench.estimators.centre_runs import track
from imubench.reproduce.arve.runs import removed
from imubench.reproduce.arve.soft_runs import SETTLED, Cell, recorded, rows_of, streamed, truth_of
from imubench.scenarios.pendulum import SoftTissue

KINDS: dict[SoftTissue, str] = {"none": "constant", "paper": "unfelt", "sliding": "felt", "sprung": "spring"}
SLIDES, SPRINGS, DAMPINGS = (0.3, 5.0), (3.0, 8.0), (0.05, 0.5)  # Hz, Hz, -


def drawn(kind: SoftTissue, i: int) -> Cell:
    rng = np.random.default_rng([11, i])
    frequency = float(rng.uniform(*SPRINGS) if kind == "sprung" else np.exp(rng.uniform(*np.log(SLIDES))))
    return Cell(kind, 0.02, frequency, float(rng.uniform(0, 2 * np.pi)), float(rng.uniform(*DAMPINGS)), 10_000 + i)


def judged(cell: Cell, stream: bool) -> list[float]:
    """Return mean |dr| of ArVE_d and `sliding`, |d mean r| of `sliding`, in mm, its squared error over its covariance
    in the middle, whether the kind is right, and mean |dr| of the stream from SETTLED on and s until 10 mm for good.
    """
    runs = recorded(truth_of(cell), cell.seed)
    a, time = removed(runs, "known"), runs.time
    covariances = covariances_of("arve-d", "constant" if cell.kind == "none" else "varying")
    tracks = track(runs.gyro, a, time, 12, covariances)
    filtered = np.linalg.norm(tracks.r[0] - runs.r[tracks.first :], axis=1).mean()
    fit = sliding.best(rows_of(runs, a))
    r, P = sliding.answer(fit, time)
    e, k = r - runs.r, time.size // 2
    squared = e[k] @ np.linalg.solve(P[k], e[k]) / 3
    found = [1e3 * filtered, 1e3 * np.linalg.norm(e, axis=1).mean(), 1e3 * np.linalg.norm(e.mean(axis=0)), squared]
    late = [np.nan, np.nan]
    if stream:
        off = np.linalg.norm(streamed(runs, a) - runs.r, axis=1)
        far = np.flatnonzero(~(off < 0.010))
        late = [1e3 * off[time >= SETTLED].mean(), float(time[far[-1]]) if far.size else 0.0]
    return [*map(float, found), float(fit.name == KINDS[cell.kind]), *map(float, late)]


def main(runs: int, streams: int) -> None:
    head = "r, runs | ArVE_d | sliding | worst | mean r, worst | over ArVE_d, worst | squared / covariance | kind right"
    print(f"| {head} | stream | worst | < 10 mm after |\n|---|" + "---:|" * 10)
    for kind in KINDS:
        found = np.array([judged(drawn(kind, i), i < streams) for i in range(runs)])
        known, ours, mean, squared, right, stream, after = found.T
        cells = [known.mean(), ours.mean(), ours.max(), mean.max(), (ours / known).max(), squared.mean()]
        line = " | ".join(f"{x:.2f}" if x < 10 else f"{x:.0f}" for x in cells)
        late = f"{np.nanmean(stream):.2f} | {np.nanmax(stream):.2f} | {np.nanmax(after):.1f} s"
        print(f"| {KINDS[kind]}, {runs} | {line} | {right.mean():.0%} | {late} |", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20, int(sys.argv[2]) if len(sys.argv) > 2 else 4)
