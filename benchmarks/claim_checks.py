"""`imubench check` on a method made 20 % worse and on one left as it was, 200 times each, beside fixed-size tests.

A pool of recordings is simulated once and solved by each method; a check of repetition r reads the pool from number
r POOL / REPETITIONS on, so that checks of more runs than that share recordings with the next repetition. The worse
method is seel2012 on the first part of each recording.
Run by name alone: `python -m benchmarks claim_checks`. What is solved is kept in runs/claim-checks-KEY.npz, whose key
changes with the code that plays and solves.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import monotonic

import numpy as np
from scipy.stats import norm, ttest_rel

from benchmarks.table import Row
from imubench.arrays import Array
from imubench.atomic import atomic_file
from imubench.checks.evidence import Evidence, MedianTest, PairedTest, log_ratio
from imubench.checks.figures import figures_of
from imubench.checks.scenario import parse_scenario
from imubench.checks.versions import ESTIMATING, SIMULATING, code_key
from imubench.estimators import ESTIMATORS
from imubench.recording import Recording
from imubench.score import score

SCENARIO = {"seconds": 10, "rig": [{"family": "hinge"}], "imu": [{"profile": "xsens_mtw"}]}
FIGURE = "best_pairing_rmsae"
REPETITIONS, POOL = 200, 2000
WORSE = 0.78  # part of a recording that makes errors 20 % larger, by the geometric mean over the pool
MARGINS = (0.2, 0.15)  # the default, and one below what is to be seen every time
SURE = 0.99  # confidence, and power where there is no baseline: the defaults of `check`
POWER = 0.9999  # of `check` beside a baseline: all of 200 repetitions fail with a probability of 98 %
CACHE = Path(f"runs/claim-checks-{code_key((*SIMULATING, *ESTIMATING))}.npz")
SAVED_EVERY = 100  # recordings

Method = Callable[[Recording], Recording]


def part(start: float, end: float) -> Method:
    """Return a method's first step: it looks at a part of the recording alone, from and to these shares of it."""

    def cut(recording: Recording) -> Recording:
        def of(length: int) -> slice:
            return slice(round(start * length), round(end * length))

        imus = (
            replace(imu, time=imu.time[rows], gyro=imu.gyro[rows], accel=imu.accel[rows])
            for imu in recording.imus
            for rows in (of(len(imu.time)),)
        )
        return replace(recording, imus=tuple(imus))

    return cut


METHODS: dict[str, Method] = {
    "all": part(0, 1),
    f"first {WORSE:g}": part(0, WORSE),
    "first 0.8": part(0, 0.8),
    "last 0.8": part(0.2, 1),
}


def pool() -> dict[str, Array]:
    """Return the errors (POOL,) in rad of every method, from the disk or computed."""
    stored: dict[str, Array] = {}
    if CACHE.exists():
        with np.load(CACHE) as file:
            stored = dict(file)
    done = {name: list(stored.get(name, ()))[:POOL] for name in METHODS}
    scenario = parse_scenario(SCENARIO, {}, Path(), "scenario")
    for number in range(POOL):
        missing = [name for name, errors in done.items() if len(errors) == number]
        if not missing:
            continue
        recording, truth = scenario.recording(number)
        for name in missing:
            answer = ESTIMATORS["seel2012"].estimate(METHODS[name](recording))
            done[name].append(figures_of(score(answer, truth))[FIGURE])
        if number % SAVED_EVERY == 0 or number + 1 == POOL:
            with atomic_file(CACHE) as partial, partial.open("wb") as file:
                np.savez(file, **{name: np.array(errors) for name, errors in done.items()})
    return {name: np.array(errors) for name, errors in done.items()}


def checks(begin: Callable[[], Evidence], values: Array, power: float = POWER) -> tuple[Array, Array]:
    """Return for each repetition whether it fails (-1), holds (1) or stays undecided (0), and after how many runs."""
    verdicts, counts = np.zeros(REPETITIONS, int), np.zeros(REPETITIONS, int)
    for r in range(REPETITIONS):
        evidence = begin()
        for n, value in enumerate(np.roll(values, -r * len(values) // REPETITIONS), 1):
            evidence.add(float(value))
            counts[r] = n
            if evidence.against >= -math.log1p(-SURE):
                verdicts[r] = -1
            elif evidence.for_it >= -math.log1p(-power):
                verdicts[r] = 1
            if verdicts[r]:
                break
    return verdicts, counts


def fixed_size(ratios: Array, margin: float) -> int:
    """Return how many pairs a t-test of log ratios needs for the same two error rates, their spread known before."""
    z = norm.ppf(SURE) + norm.ppf(POWER)
    return math.ceil((z * float(np.std(ratios)) / math.log1p(margin)) ** 2)


def fixed_size_failures(candidate: Array, baseline: Array, count: int) -> int:
    """Return in how many repetitions that test, of `count` pairs, says that the candidate is worse."""
    x, y = np.log(candidate), np.log(baseline)
    windows = (np.arange(count) + r * len(x) // REPETITIONS for r in range(REPETITIONS))
    return sum(ttest_rel(x[w % len(x)], y[w % len(x)], alternative="greater").pvalue < 1 - SURE for w in windows)


def paired(candidate: Array, baseline: Array) -> Array:
    return np.array([log_ratio(*pair) for pair in zip(candidate, baseline, strict=True)])


def run() -> list[Row]:
    start = monotonic()
    every, worse, first, last = pool().values()
    factor, spread = math.exp(np.mean(paired(worse, every))), np.std(paired(worse, every))
    middle = math.exp(np.median(paired(worse, every)))
    print(
        f"pool: {POOL} recordings, {monotonic() - start:.0f} s; errors of the worse method: {factor:.3f} times by the "
        f"geometric mean, {middle:.3f} by the median, std of the log {spread:.2f}"
    )
    cases = (
        (f"20 % worse: only the first {100 * WORSE:.0f} % of each recording is used", worse, every, "fail"),
        ("20 % worse: every error times 1.2", 1.2 * every, every, "fail"),
        ("unchanged", every, every, "pass"),
        ("as good, with other errors: the last 80 % beside the first 80 %", last, first, "pass"),
    )  # fmt: skip
    rows = [_beside(*case, margin) for margin in MARGINS for case in cases]
    bound, margin = float(np.median(every)), MARGINS[0]
    for what, method, wanted in (("unchanged", every, "pass"), ("20 % worse", worse, "fail")):
        found = checks(lambda: MedianTest(bound, margin), method, SURE)
        rows.append(_row(f"median <= that of the pool, margin {100 * margin:.0f} %, {what}", *found, wanted))
    return rows


def _beside(what: str, candidate: Array, baseline: Array, wanted: str, margin: float) -> Row:
    ratios = paired(candidate, baseline)
    verdicts, counts = checks(lambda: PairedTest(margin), ratios)
    fixed, peer, gain = fixed_size(ratios, margin), "-", "-"
    if fixed > 2:  # or there is no spread
        peer = f"t-test of {fixed} pairs: fails {fixed_size_failures(candidate, baseline, fixed)}"
        gain = f"{fixed / float(np.mean(counts)):.1f}"
    return _row(f"beside a baseline, margin {100 * margin:.0f} %, {what}", verdicts, counts, wanted, peer, gain)


def _row(what: str, verdicts: Array, counts: Array, wanted: str, peer: str = "-", gain: str = "-") -> Row:
    fails, holds = int(np.sum(verdicts < 0)), int(np.sum(verdicts > 0))
    return Row(
        what,
        f"{fails} fail, {holds} hold; {np.mean(counts):.0f} runs, {np.percentile(counts, 90):.0f} at 90 %",
        peer,
        gain,
        "200 fail" if wanted == "fail" else ">= 198 hold",
        fails == REPETITIONS if wanted == "fail" else holds >= 198,
    )
