"""Sample selection on sequence 1 of Olsson 2020, 35,000 samples to 1000, side by side with qmt and the literal form."""

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.table import Row
from imubench.arrays import Array
from imubench.estimators.selection import Selected, select
from imubench.estimators.selection_online import OnlineSelection
from imubench.scenarios.olsson2020.sequences import assemble

N_MAX = 1000
BATCH = 50  # samples, one second
LONGEST = 0.020  # s, for one update
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


def samples(seed: int = 1) -> tuple[Array, ...]:
    """Return gyro1, gyro2, accel1, accel2 (35000, 3) of sequence 1."""
    one, two = assemble("sequence1", seed=seed).recording.imus
    return one.gyro, two.gyro, one.accel, two.accel


def qmt_selection(gyro1: Array, gyro2: Array, accel1: Array, accel2: Array) -> Selected:
    """Return what qmt selects, by the part of jointAxisEstHingeOlsson that only selects."""
    from qmt.functions.joint_axis_est_hinge_olsson import jointAxisSampleSelection

    settings = {"winSize": 21, "dataSize": N_MAX, "angRateEnergyThreshold": 1}
    imus = ({"gyr": g.T.copy(), "acc": a.T.copy()} for g, a in ((gyro1, accel1), (gyro2, accel2)))
    _, _, found = jointAxisSampleSelection(*imus, settings)
    gyro, accel = (np.sort(found[name].ravel()) for name in ("gyrSamples", "accSamples"))
    return Selected(gyro, accel, gyro1[gyro], gyro2[gyro], accel1[accel], accel2[accel])


def seconds(work: Callable[[], Selected], repeats: int = 5) -> tuple[float, Selected]:
    took = []
    for _ in range(repeats):
        start = time.perf_counter()
        selected = work()
        took.append(time.perf_counter() - start)
    return statistics.median(took), selected


def literally() -> tuple[float, list[int]]:
    """Return the seconds and the set of the literal form, in a process of its own with one thread.

    Threads are a hindrance to decompositions as narrow as these, by a factor of seven on two busy cores.
    """
    command = [sys.executable, "-m", "benchmarks.selection"]
    alone = os.environ | dict.fromkeys(THREADS, "1")
    took, kept = json.loads(subprocess.run(command, env=alone, check=True, capture_output=True, text=True).stdout)
    return took, kept


def updates(arrays: tuple[Array, ...]) -> list[float]:
    """Return the processor time in s of every update of one second of data, over all of the sequence."""
    stream, took = OnlineSelection(N_MAX), []
    for k in range(0, len(arrays[0]), BATCH):
        start = time.process_time()
        stream.update(*(a[k : k + BATCH] for a in arrays))
        took.append(time.process_time() - start)
    return took


def run() -> list[Row]:
    arrays = samples()
    printed, one_by_one = seconds(partial(select, *arrays, N_MAX))
    literal, yardstick = literally()
    batched, in_batches = seconds(partial(select, *arrays, N_MAX, form="batched"))
    same = one_by_one.accel.tolist() == yardstick
    took = updates(arrays)
    late = statistics.median(took[-100:])
    rows = [
        Row(
            "Algorithm 3 as printed, Gram matrix beside SVD for each sample"
            + (", same sets" if same else ", NOT SAME"),
            f"{printed:.3f} s",
            f"{literal:.1f} s",
            f"{literal / printed:.0f}",
            ">= 50",
            same and literal >= 50 * printed,
        ),
        Row(
            f"selection on a stream, {BATCH} new samples: longest of {len(took)} updates, processor time",
            f"{1e3 * max(took):.1f} ms",
            f"{1e3 * late:.2f} ms, median of the last 100",
            "-",
            "< 20 ms",
            max(took) < LONGEST,
        ),
    ]
    try:
        theirs, peer = seconds(partial(qmt_selection, *arrays), 3)
    except ModuleNotFoundError:
        return rows
    same = np.array_equal(in_batches.accel, peer.accel) and np.array_equal(in_batches.gyro, peer.gyro)
    return [
        Row(
            "Algorithms 2 and 3 one sample at a time, 35,000 to 1000, beside qmt's in batches",
            f"{printed:.3f} s",
            f"{theirs:.3f} s",
            f"{theirs / printed:.1f}",
            ">= 1",
            theirs >= printed,
        ),
        Row(
            "Algorithms 2 and 3 in batches, beside qmt's" + (", same sets" if same else ", NOT SAME"),
            f"{batched:.4f} s",
            f"{theirs:.3f} s",
            f"{theirs / batched:.0f}",
            ">= 10",
            same and theirs >= 10 * batched,
        ),
        *rows,
    ]


if __name__ == "__main__":
    took, found = seconds(partial(select, *samples(), N_MAX, form="literal"), 1)
    print(json.dumps([took, found.accel.tolist()]))
