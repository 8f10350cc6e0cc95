"""Evidence for and against a claim, run by run: e-processes, which may be looked at after every run.

An e-process begins at 1 and, while its hypothesis is true, is no larger on average after any number of runs. So it
passes 1 / a with a probability of at most a, whenever one stops (Ville's inequality). A claim has two of them:
`against` the hypothesis that it is true, and `for_it` against the hypothesis that it is broken by its margin. Both are
kept as logarithms. docs/claim-statistics.md has the equations, and why each test was chosen.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from imubench.arrays import Array

STAKES = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Shares of what is at stake in each bet against a mean: the best depends on how errors spread, so all are held."""
CLIP = 3.0
"""Times the broken level, or the spread of log ratios around the margin, at which a value counts as clipped in
`for_it`: of normal ones 0.3 % are larger."""
BOLDEST = 0.9
"""Of a bet on one run: 1 would lose everything by one run that went the other way."""
DEGREES = 5.0
"""Of freedom of Student's t in the paired test's weights: logarithms of ratios have longer tails than a normal one."""
PRIOR_PAIRS, PRIOR_SPREAD = 4, 2.0
"""How many pairs, apart by so many times the margin, the spread begins with, so that the first few do not decide it."""
LARGEST = 100.0
"""Of a log ratio that enters the spread: where one of two has no estimate it is infinite."""
NORMAL_MAD = 1.4826
"""Standard deviation of a normal variable over the median of its absolute deviation."""


class Evidence(Protocol):
    """What runs say about a claim; begins without any."""

    @property
    def against(self) -> float:
        """The log of the evidence that the claim is wrong."""

    @property
    def for_it(self) -> float:
        """The log of the evidence that it is not broken by its margin."""

    def add(self, value: float) -> None:
        """Take in one run's value: an error in SI units or a log ratio; inf where there is no estimate."""


@dataclass
class ShareTest:
    """At least a share `claimed` of the errors is within `bound`, or only `broken`: Wald's test of a proportion."""

    bound: float
    claimed: float
    broken: float
    against: float = 0.0
    for_it: float = 0.0

    def add(self, error: float) -> None:
        """Take in one error."""
        within = error <= self.bound
        ratio = self.broken / self.claimed if within else (1.0 - self.broken) / (1.0 - self.claimed)
        self.against += math.log(ratio)
        self.for_it -= math.log(ratio)


class _Wagered:
    """Bets against a claim, and bets for it."""

    _against: "_Bets"
    _for_it: "_Bets"

    @property
    def against(self) -> float:
        """The log of the evidence that the claim is wrong."""
        return self._against.log

    @property
    def for_it(self) -> float:
        """The log of the evidence that it is not broken."""
        return self._for_it.log


class MeanTest(_Wagered):
    """The mean of errors raised to `power` is that of the bound at most, or that of `bound` (1 + margin) or more.

    Evidence against it is of a mean larger than claimed; for it, of clipped errors with a mean below the broken level.
    """

    def __init__(self, bound: float, margin: float, power: int) -> None:
        self.bound, self.broken, self.power = bound, bound * (1.0 + margin), power
        self._against = _Bets(np.asarray(STAKES))
        room = CLIP**power - 1.0
        self._for_it = _Bets(-np.asarray(STAKES) / room)  # the largest clipped error loses a bet of 1 / room

    def add(self, error: float) -> None:
        """Take in one error."""
        self._against.add((error / self.bound) ** self.power - 1.0)
        self._for_it.add(min(error / self.broken, CLIP) ** self.power - 1.0)


class MedianTest(_Wagered):
    """Half of the errors are within the bound, or half of them are `bound` (1 + margin) or more.

    Evidence against it is of fewer than half within the bound; for it, of more than half below the broken level.
    """

    def __init__(self, bound: float, margin: float) -> None:
        self.bound, self.broken = bound, bound * (1.0 + margin)
        self._against, self._for_it = _Bets(np.asarray(STAKES)), _Bets(-np.asarray(STAKES))

    def add(self, error: float) -> None:
        """Take in one error."""
        self._against.add(1.0 if error > self.bound else -1.0)
        self._for_it.add(1.0 if error >= self.broken else -1.0)


class _Bets:
    """The log of the mean of prod(1 + stake x) over some stakes, for values x of mean 0 or less (stakes > 0)."""

    def __init__(self, stakes: Array) -> None:
        self._stakes, self._logs = stakes, np.zeros(len(stakes))

    def add(self, x: float) -> None:
        with np.errstate(over="ignore"):
            self._logs += np.log1p(self._stakes * x)

    @property
    def log(self) -> float:
        return float(np.logaddexp.reduce(self._logs)) - math.log(len(self._logs))


class PairedTest:
    """On the same seeds a candidate errs as a baseline does, or `margin` times more, on most runs or on average.

    Evidence against it is of signs of log ratios, weighted; it is exact where exchanging the two on any seed changes
    nothing. The weight of a sign depends on the size of its log ratio and on the spread of those before it.

    Evidence for it has to show two things, and is the lesser of both: by the same signs that the candidate does not
    err 1 + margin times more, and by bets on the log ratios themselves that their mean, that of the logarithm of the
    geometric mean, is below the margin's. Ratios have a long tail to one side where a method has become worse on some
    recordings: then signs alone follow the median, and pass what is worse by the margin on average.
    """

    def __init__(self, margin: float) -> None:
        self.shift = math.log1p(margin)
        self.against = self._by_signs = self._by_mean = 0.0
        self._ratios: list[float] = []

    @property
    def for_it(self) -> float:
        """The log of the evidence that it is not broken."""
        return min(self._by_signs, self._by_mean)

    def add(self, log_ratio: float) -> None:
        """Take in the log of the candidate's error over the baseline's; inf where the candidate alone has none."""
        spread = _spread(self._ratios, PRIOR_SPREAD * self.shift, self.shift / 2)
        self.against += _sign_bet(log_ratio, spread, self.shift)
        self._by_signs += _sign_bet(self.shift - log_ratio, spread, self.shift)
        self._by_mean += _mean_bet(
            self.shift - log_ratio, _spread(self._ratios, self.shift, self.shift / 4), self.shift
        )
        self._ratios.append(log_ratio)


def _sign_bet(difference: float, spread: float, shift: float) -> float:
    """Return log(1 +- weight), the sign that of the difference: how much likelier it is around `shift` than -`shift`.

    Beyond the size of the greatest weight the weight stays: a single gross difference decides nothing.
    """
    if difference == 0.0:
        return 0.0
    size = min(abs(difference), math.sqrt(DEGREES * spread**2 + shift**2))
    far, near = ((size + s * shift) ** 2 / (DEGREES * spread**2) for s in (1, -1))
    weight = min(math.tanh(0.25 * (DEGREES + 1.0) * (math.log1p(far) - math.log1p(near))), BOLDEST)
    return math.log1p(math.copysign(weight, difference))


def _mean_bet(below: float, spread: float, shift: float) -> float:
    """Return log(1 + stake x), x by how much a log ratio is below the margin's, at most `CLIP` spreads either way.

    The stake is the one that grows fastest where log ratios are around 0 with that spread, and no bolder than that one
    run at the clip loses `BOLDEST` of what there is. Both depend on earlier runs alone, so that the bet is fair.
    """
    clip = CLIP * spread
    stake = min(shift / (spread**2 + shift**2), BOLDEST / clip)
    return math.log1p(stake * min(max(below, -clip), clip))


def _spread(before: Sequence[float], prior: float, least: float) -> float:
    """Return the standard deviation of the log ratios so far, by their median absolute deviation.

    Args:
        before: those of the earlier runs.
        prior: what it begins with, as if `PRIOR_PAIRS` runs had been so far from the median.
        least: it is never below this: half the shift, where every sign counts fully.
    """
    values = np.clip(before, -LARGEST, LARGEST)
    apart = np.abs(values - np.median(values)) if len(values) else values
    return max(NORMAL_MAD * float(np.median([*apart, *[prior / NORMAL_MAD] * PRIOR_PAIRS])), least)


def log_ratio(candidate: float, baseline: float) -> float:
    """Return log(candidate / baseline) of two errors >= 0, which may be 0 or inf; 0 where both are the same."""
    if candidate == baseline:
        return 0.0
    if math.isinf(candidate) or baseline == 0.0:
        return math.inf
    if math.isinf(baseline) or candidate == 0.0:
        return -math.inf
    return math.log(candidate / baseline)
