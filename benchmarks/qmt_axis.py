"""The hinge axis side by side with qmt's jointAxisEstHingeOlsson: Algorithm 1 from the same cold start."""

import statistics
import time
from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.hinge_rigs import HingeRig, random_rig
from benchmarks.table import Row
from imubench.arrays import Array
from imubench.estimators.olsson2020 import estimate, solve
from imubench.score import axis_deviation

START = np.zeros(4)  # qmt's default x0
RIGS = 20
TIMED = 5  # rigs


def ours(rig: HingeRig) -> Array:
    best, _ = solve(*rig.gyro, *rig.accel, START)
    return best.axes


def coldly(rig: HingeRig) -> Array:
    return estimate(rig.recording()).value


def peer(rig: HingeRig) -> Array:
    import qmt

    first, second = qmt.jointAxisEstHingeOlsson(*rig.accel, *rig.gyro, {"x0": START.copy(), "quiet": True})
    return np.stack([first[:, 0], second[:, 0]])


def error_deg(axes: Array, rig: HingeRig) -> float:
    return float(np.degrees(axis_deviation(axes, rig.axes).max()))


def median_seconds(work: Callable[[], object], repeats: int) -> float:
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def accuracy() -> list[Row]:
    rigs = [random_rig(np.random.default_rng(seed), lever=0.05, amplitude=0.5) for seed in range(RIGS)]
    errors = np.array([[error_deg(axes, rig) for axes in (ours(rig), coldly(rig), peer(rig))] for rig in rigs])
    rows = []
    for name, mine in (("Algorithm 1 from qmt's start", errors[:, 0]), ("estimate(), no start", errors[:, 1])):
        excess = float((mine - errors[:, 2]).max())
        cells = [f"{np.median(e):.4f} median, {e.max():.4f} worst" for e in (mine, errors[:, 2])]
        what = f"hinge axis error of {RIGS} clean rigs, deg: {name}"
        rows.append(Row(what, *cells, f"worst excess {excess:.1e}", "excess <= 0.02 deg", excess <= 0.02))
    return rows


def speed(count: int) -> Row:
    rigs = [random_rig(np.random.default_rng(seed), count=count, lever=0.05, amplitude=0.5) for seed in range(TIMED)]
    mine = statistics.median(median_seconds(partial(ours, rig), 15) for rig in rigs)
    theirs = statistics.median(median_seconds(partial(peer, rig), 3) for rig in rigs)
    ratio = theirs / mine
    what = f"hinge axis, Algorithm 1 with both sign pairings, {count} samples"
    return Row(what, f"{1e3 * mine:.2f} ms", f"{1e3 * theirs:.2f} ms", f"{ratio:.1f}", ">= 10", ratio >= 10.0)


def run() -> list[Row]:
    return [*accuracy(), speed(3000), speed(35000)]


def main() -> None:
    for row in run():
        verdict = "met" if row.met else "MISSED"
        print(f"{row.what}\n    ours {row.ours} | qmt {row.peer} | {row.ratio} | required {row.required}: {verdict}")


if __name__ == "__main__":
    main()
