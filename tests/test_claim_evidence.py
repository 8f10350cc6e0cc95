"""The sequential tests: their error rates are what a check says, whatever the errors' distribution."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import binom, norm

from imubench.checks import evidence
from imubench.checks.evidence import Evidence, MeanTest, MedianTest, PairedTest, ShareTest, log_ratio

MARGIN = 0.2
SHIFT = math.log1p(MARGIN)
RATE = 0.05  # of either error: large enough to be seen in some hundred repetitions
MOST = 3000  # runs after which a repetition counts as undecided

Draw = Callable[[np.random.Generator], float]


def decided(begin: Callable[[], Evidence], draw: Draw, rng: np.random.Generator, rate: float) -> tuple[str, int]:
    test, enough = begin(), -math.log(rate)
    for n in range(1, MOST + 1):
        test.add(draw(rng))
        if test.against >= enough:
            return "fails", n
        if test.for_it >= enough:
            return "holds", n
    return "undecided", MOST


def study(begin, draw, repetitions: int, rate: float = RATE, seed: int = 0) -> tuple[dict[str, int], float]:
    """Return how often each verdict comes, and how many runs it takes on average."""
    rng = np.random.default_rng(seed)
    results = [decided(begin, draw, rng, rate) for _ in range(repetitions)]
    verdicts = [verdict for verdict, _ in results]
    return {v: verdicts.count(v) for v in ("fails", "holds", "undecided")}, float(np.mean([n for _, n in results]))


def most(repetitions: int, rate: float = RATE) -> int:
    """Return what a count of that rate exceeds with a probability of 0.1 %."""
    return int(binom.ppf(0.999, repetitions, rate))


def skewed(mean: float, rng: np.random.Generator) -> float:
    """Return a log ratio whose mean is given and whose median is 0.06 less, with a standard deviation of 0.44.

    So are those of a method that has become worse on some recordings: with a mean of log(1.2), 13 % by the median.
    """
    return mean + 0.44 * (rng.gamma(5.5) - 5.5) / math.sqrt(5.5)


def within(p: float) -> Draw:
    return lambda rng: 0.5 if rng.random() < p else 2.0


def lognormal(std: float, rms: float) -> Draw:
    return lambda rng: rms * math.exp(rng.normal(-(std**2), std))


def gross(often: float, rms: float) -> Draw:
    """Small errors, and `often` one ten times as large."""
    small = rms / math.sqrt(1 - often + 100 * often)
    return lambda rng: 10 * small if rng.random() < often else small


TRUE: dict[str, tuple[Callable[[], Evidence], Draw]] = {
    "share": (lambda: ShareTest(1.0, 0.9, 0.8), within(0.9)),
    "rms, normal": (lambda: MeanTest(1.0, MARGIN, 2), lambda rng: abs(rng.normal())),
    "rms, long tail": (lambda: MeanTest(1.0, MARGIN, 2), lognormal(0.7, 1.0)),
    "rms, 5 % gross": (lambda: MeanTest(1.0, MARGIN, 2), gross(0.05, 1.0)),
    "mean, exponential": (lambda: MeanTest(1.0, MARGIN, 1), lambda rng: rng.exponential()),
    "median, long tail": (lambda: MedianTest(1.0, MARGIN), lambda rng: math.exp(0.7 * rng.normal())),
    "paired, normal": (lambda: PairedTest(MARGIN), lambda rng: 0.3 * rng.normal()),
    "paired, long tail": (lambda: PairedTest(MARGIN), lambda rng: 0.2 * rng.standard_t(2)),
    "paired, mostly the same": (
        lambda: PairedTest(MARGIN),
        lambda rng: 0.0 if rng.random() < 0.7 else rng.normal(),
    ),
}
"""Claims that are just true: by the distributions that make a test err most often."""
BROKEN: dict[str, tuple[Callable[[], Evidence], Draw]] = {
    "share": (lambda: ShareTest(1.0, 0.9, 0.8), within(0.8)),
    "rms, normal": (lambda: MeanTest(1.0, MARGIN, 2), lambda rng: 1.205 * abs(rng.normal())),  # 1.2 when clipped
    "mean, uniform": (lambda: MeanTest(1.0, MARGIN, 1), lambda rng: rng.uniform(0, 2.4)),
    "median, long tail": (lambda: MedianTest(1.0, MARGIN), lambda rng: 1.2 * math.exp(0.7 * rng.normal())),
    "paired, normal": (lambda: PairedTest(MARGIN), lambda rng: SHIFT + 0.3 * rng.normal()),
    "paired, long tail": (lambda: PairedTest(MARGIN), lambda rng: SHIFT + 0.2 * rng.standard_t(2)),
    "paired, long tail to one side": (lambda: PairedTest(MARGIN), lambda rng: skewed(SHIFT, rng)),
}
"""Claims that are just broken by the margin."""


@pytest.mark.parametrize("name", ["share", "rms, long tail", "paired, long tail"])
def test_a_true_claim_seldom_fails(name):
    verdicts, _ = study(*TRUE[name], 60)
    assert verdicts["fails"] <= most(60)


@pytest.mark.parametrize("name", ["share", "rms, normal", "paired, normal"])
def test_a_broken_claim_is_seldom_passed(name):
    verdicts, _ = study(*BROKEN[name], 60)
    assert verdicts["holds"] <= most(60)


@pytest.mark.long
@pytest.mark.parametrize("name", TRUE)
def test_a_true_claim_fails_no_more_often_than_is_said(name):
    verdicts, _ = study(*TRUE[name], 400, seed=1)
    assert verdicts["fails"] <= most(400)
    assert verdicts["undecided"] <= 4  # 1 %: gross errors take longest


@pytest.mark.long
@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_claim_holds_no_more_often_than_is_said(name):
    verdicts, _ = study(*BROKEN[name], 400, seed=2)
    assert verdicts["holds"] <= most(400)
    assert verdicts["fails"] >= 400 - most(400) - 4  # 1 % undecided


@pytest.mark.parametrize("spread", [0.05, 0.3, 2.0])
@pytest.mark.parametrize("size", [1e-3, 0.1, 0.5, 3.0, math.inf])
def test_a_bet_on_a_sign_is_fair_and_no_larger_difference_counts_less(spread, size):
    up, down = (evidence._sign_bet(sign * size, spread, SHIFT) for sign in (1, -1))
    assert math.exp(up) + math.exp(down) == pytest.approx(2.0, abs=1e-12)  # rounding
    assert evidence._sign_bet(0.9 * size, spread, SHIFT) <= up


def test_a_bet_on_a_mean_is_fair_at_the_bound():
    """Of two errors whose mean square is the bound's, and of two whose is the broken level's, it is 1 on average."""
    for level, side in ((1.0, "against"), (1.0 + MARGIN, "for_it")):
        values = []
        for square in (0.25, 1.75):
            test = MeanTest(1.0, MARGIN, 2)
            test.add(level * math.sqrt(square))
            values.append(math.exp(getattr(test, side)))
        assert np.mean(values) == pytest.approx(1.0, abs=1e-12)  # rounding


def test_an_unchanged_method_passes_and_one_that_is_always_worse_fails_after_ten_runs():
    for ratio, verdict in ((0.0, "holds"), (SHIFT, "fails"), (1.0, "fails")):
        verdicts, needed = study(lambda: PairedTest(MARGIN), lambda rng, r=ratio: r, 1, 0.01)
        assert verdicts[verdict] == 1
        assert needed <= (11 if verdict == "holds" else 10)  # 0.5 log(100) and what the first four runs cannot stake


def test_what_is_worse_on_average_fails_though_its_median_is_less():
    """By signs alone a method 20 % worse by the geometric mean, 13 % by the median, passed in 9 of 400 checks."""
    rng = np.random.default_rng(0)
    assert 1.11 < math.exp(np.median([skewed(SHIFT, rng) for _ in range(4000)])) < 1.15
    verdicts, _ = study(lambda: PairedTest(MARGIN), lambda rng: skewed(SHIFT, rng), 100, 0.01)
    assert verdicts["holds"] <= most(100, 0.01)


def test_a_bet_on_the_mean_of_log_ratios_is_fair_at_the_margin():
    """Of two log ratios whose mean is the margin's, it is 1 on average; beyond the clip nothing more is lost."""
    for spread in (0.05, 0.3, 2.0):
        up, down = (evidence._mean_bet(side * 0.1, spread, SHIFT) for side in (1, -1))
        assert math.exp(up) + math.exp(down) == pytest.approx(2.0, abs=1e-12)  # rounding
        worst = evidence._mean_bet(-math.inf, spread, SHIFT)
        assert worst == evidence._mean_bet(-evidence.CLIP * spread, spread, SHIFT)
        assert math.exp(worst) >= 1 - evidence.BOLDEST - 1e-12  # rounding


def test_a_change_in_a_third_of_the_runs_is_seen():
    """The median ratio does not see it: two thirds of the runs are as they were, a third has three times the error."""
    verdicts, _ = study(lambda: PairedTest(MARGIN), lambda rng: math.log(3) * (rng.random() < 0.33), 100, 0.01)
    assert verdicts["fails"] > 80


def test_a_missing_estimate_is_an_infinite_error():
    mean = MeanTest(1.0, MARGIN, 2)
    for error in (0.1, 0.2, math.inf):
        mean.add(error)
    assert mean.against == math.inf
    share = ShareTest(1.0, 0.9, 0.8)
    share.add(math.inf)
    assert share.against == pytest.approx(math.log(2.0))  # 0.2 / 0.1
    paired = PairedTest(MARGIN)
    for _ in range(30):
        paired.add(log_ratio(math.inf, 0.1))
    assert paired.against > math.log(100) > 0 > paired.for_it


def test_log_ratios_of_errors_that_are_zero_or_missing():
    assert log_ratio(2.0, 1.0) == pytest.approx(math.log(2))
    assert log_ratio(0.0, 0.0) == log_ratio(math.inf, math.inf) == 0.0
    assert log_ratio(1.0, 0.0) == log_ratio(math.inf, 1.0) == math.inf
    assert log_ratio(0.0, 1.0) == log_ratio(1.0, math.inf) == -math.inf


def test_fewer_than_half_of_the_runs_of_a_fixed_size():
    """A share of 0.97 claimed to be 0.9, and errors of one seed 40 % apart, with all rates at 1 %."""
    z = norm.ppf(0.99)
    fixed = (z * (math.sqrt(0.9 * 0.1) + math.sqrt(0.8 * 0.2)) / 0.1) ** 2
    _, needed = study(lambda: ShareTest(1.0, 0.9, 0.8), within(0.97), 60, 0.01)
    assert needed < fixed / 2
    fixed = (2 * z * 0.4 / SHIFT) ** 2
    _, needed = study(lambda: PairedTest(MARGIN), lambda rng: 2 * SHIFT + 0.4 * rng.normal(), 60, 0.01)
    assert needed < fixed / 2
    _, needed = study(lambda: PairedTest(MARGIN), lambda rng: SHIFT + 0.4 * rng.normal(), 60, 0.01)
    assert needed < 0.7 * fixed  # just at the margin, where both take longest; Wald's limit is 0.42
