"""`imubench check` on a method made 20 % worse and on one left as it was, 200 times each, beside fixed-size tests.

A pool of recordings is simulated once and solved by each method; a check of repetition r reads the pool from number
r POOL / REPETITIONS on, so that checks of more runs than that share recordings with the next repetition. A worse method
is seel2012 on the first part of each recording, the part chosen on other recordings so that errors are 20 % larger.
Run by name alone: `python -m benchmarks claim_checks`. What is solved is kept in runs/claim-checks.npz.
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
from imubench.checks.scenario import Drawn, parse_scenario
from imubench.estimators import ESTIMATORS
from imubench.recording import Recording
from imubench.score import score

SCENARIO = {"seconds": 10, "rig": [{"family": "hinge"}], "imu": [{"profile": "xsens_mtw"}]}
FIGURE = "best_pairing_rmsae"
REPETITIONS, POOL = 200, 4000
CALIBRATION, OTHERS = 600, 1_000_000  # recordings by which the worse method is chosen, and their first number
PARTS = (0.58, 0.61, 0.64, 0.67, 0.70)
MARGIN, SURE = 0.2, 0.99
POWER = 0.999  # a method that is worse shall fail in all of 200 repetitions
CACHE = Path("runs/claim-checks.npz")
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


def solved(methods: dict[str, Method], first: int, count: int, tell: Callable[[Array], None] | None = None) -> Array:
    """Return the errors (count, methods) in rad of seel2012 behind each first step."""
    scenario = parse_scenario(SCENARIO, {}, Path(), "scenario")
    assert isinstance(scenario, Drawn)
    rows: list[list[float]] = []
    for number in range(first, first + count):
        recording, truth = scenario.recording(number)
        answers = (ESTIMATORS["seel2012"].estimate(step(recording)) for step in methods.values())
        rows.append([figures_of(score(answer, truth))[FIGURE] for answer in answers])
        if tell is not None and len(rows) % SAVED_EVERY == 0:
            tell(np.array(rows))
    return np.array(rows)


def twenty_percent_worse() -> tuple[float, float]:
    """Return the part of a recording that makes errors 20 % larger, and their factor: geometric mean of the ratios."""
    methods = {"all": part(0, 1), **{f"{p}": part(0, p) for p in PARTS}}
    errors = np.log(solved(methods, OTHERS, CALIBRATION))
    factors = np.exp(np.mean(errors[:, 1:] - errors[:, :1], axis=0))
    best = int(np.argmin(np.abs(factors - (1 + MARGIN))))
    return PARTS[best], float(factors[best])


def pool() -> tuple[dict[str, Array], float, float]:
    """Return the errors of every method over the pool, from the disk or computed; and the worse method's part."""
    stored: dict[str, Array] = {}
    if CACHE.exists():
        with np.load(CACHE) as file:
            stored = dict(file)
    if "share" not in stored:
        share, factor = twenty_percent_worse()
        stored = {"share": np.array([share, factor]), "errors": np.zeros((0, 4))}
        _save(stored)
    share, factor = stored["share"]
    methods = {"all": part(0, 1), "worse": part(0, share), "first": part(0, 0.8), "last": part(0.2, 1)}
    before = stored["errors"]

    def keep(new: Array) -> None:
        _save({**stored, "errors": np.concatenate([before, new])})

    left = POOL - len(before)
    errors = np.concatenate([before, solved(methods, len(before), left, keep)]) if left > 0 else before
    return dict(zip(methods, errors.T, strict=True)), float(share), float(factor)


def _save(arrays: dict[str, Array]) -> None:
    with atomic_file(CACHE) as partial, partial.open("wb") as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]


def checks(begin: Callable[[], Evidence], values: Array) -> tuple[Array, Array]:
    """Return for each repetition whether it fails (-1), holds (1) or stays undecided (0), and after how many runs."""
    verdicts, counts = np.zeros(REPETITIONS, int), np.zeros(REPETITIONS, int)
    for r in range(REPETITIONS):
        evidence = begin()
        for n, value in enumerate(np.roll(values, -r * len(values) // REPETITIONS), 1):
            evidence.add(float(value))
            counts[r] = n
            if evidence.against >= -math.log1p(-SURE):
                verdicts[r] = -1
            elif evidence.for_it >= -math.log1p(-POWER):
                verdicts[r] = 1
            if verdicts[r]:
                break
    return verdicts, counts


def fixed_size(ratios: Array) -> int:
    """Return how many pairs a t-test of log ratios needs for the same two error rates, their spread known before."""
    z = norm.ppf(SURE) + norm.ppf(POWER)
    return math.ceil((z * float(np.std(ratios)) / math.log1p(MARGIN)) ** 2)


def fixed_size_failures(candidate: Array, baseline: Array, count: int) -> int:
    """Return in how many repetitions that test, of `count` pairs, says that the candidate is worse."""
    x, y = np.log(candidate), np.log(baseline)
    windows = (np.arange(count) + r * len(x) // REPETITIONS for r in range(REPETITIONS))
    return sum(ttest_rel(x[w % len(x)], y[w % len(x)], alternative="greater").pvalue < 1 - SURE for w in windows)


def paired(candidate: Array, baseline: Array) -> Array:
    return np.array([log_ratio(*pair) for pair in zip(candidate, baseline, strict=True)])


def run() -> list[Row]:
    start = monotonic()
    errors, share, factor = pool()
    print(f"pool: {POOL} recordings, {monotonic() - start:.0f} s; part {share:g}, {factor:.3f} times on others")
    rows = []
    every, worse = errors["all"], errors["worse"]
    cases = (
        (f"20 % worse: only the first {100 * share:.0f} % of each recording is used", worse, every, "fail"),
        ("20 % worse: every error times 1.2", 1.2 * every, every, "fail"),
        ("unchanged", every, every, "pass"),
        ("as good, with other errors: the last 80 % beside the first 80 %", errors["last"], errors["first"], "pass"),
    )  # fmt: skip
    for what, candidate, baseline, wanted in cases:
        ratios = paired(candidate, baseline)
        verdicts, counts = checks(lambda: PairedTest(MARGIN), ratios)
        rows.append(
            _row(f"beside a baseline, {what}", verdicts, counts, wanted, fixed_size(ratios), candidate, baseline)
        )
    bound = float(np.median(every))
    for what, method, wanted in (("unchanged", every, "pass"), ("20 % worse", worse, "fail")):
        verdicts, counts = checks(lambda: MedianTest(bound, MARGIN), method)
        rows.append(_row(f"median <= that of the pool, {what}", verdicts, counts, wanted))
    return rows


def _row(
    what: str,
    verdicts: Array,
    counts: Array,
    wanted: str,
    fixed: int | None = None,
    candidate: Array | None = None,
    baseline: Array | None = None,
) -> Row:
    fails, holds = int(np.sum(verdicts < 0)), int(np.sum(verdicts > 0))
    needed = float(np.mean(counts))
    met = fails == REPETITIONS if wanted == "fail" else holds >= 198
    peer, ratio = "-", "-"
    if fixed is not None and candidate is not None and baseline is not None and fixed > 2:
        peer = f"{fixed} pairs; fails {fixed_size_failures(candidate, baseline, fixed)}"
        ratio = f"{fixed / needed:.1f}"
    return Row(
        f"{what}: fails, holds of {REPETITIONS}; runs on average, at 90 %; peer: a t-test of fixed size",
        f"{fails}, {holds}; {needed:.0f}, {np.percentile(counts, 90):.0f}",
        peer,
        ratio,
        "200 fail" if wanted == "fail" else ">= 198 hold",
        met,
    )
