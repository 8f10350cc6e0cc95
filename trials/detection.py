"""What a test that is told what to look for would see, and how often a diagnosis saw it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, ncx2

from imubench.trials.scoring import CaseScore

Z95 = 1.959964
LEVEL = 0.01  # false alarms of the test that the theoretical power belongs to
STRENGTHS = ((0.0, 2.0), (2.0, 4.0), (4.0, 6.5), (6.5, 10.0), (10.0, 30.0), (30.0, float("inf")))


@dataclass(frozen=True)
class PowerRow:
    """Detection of lone effects of one strength, and what theory gives for the same cases."""

    low: float
    high: float
    n: int
    hits: int
    interval: tuple[float, float]
    theory: float


def wilson(hits: int, n: int) -> tuple[float, float]:
    """Return the 95 % Wilson interval of a share; (0, 1) of nothing."""
    if n == 0:
        return 0.0, 1.0
    p, z2 = hits / n, Z95**2
    middle = (p + z2 / (2 * n)) / (1 + z2 / n)
    half = Z95 / (1 + z2 / n) * np.sqrt(p * (1 - p) / n + z2 / (4 * n**2))
    return max(0.0, float(middle - half)), min(1.0, float(middle + half))


def power(strength: float, freedom: int, level: float = LEVEL) -> float:
    """Return how often a test at a level sees an effect of `freedom` numbers, `strength` standard deviations large.

    Non-central chi-square with non-centrality strength^2: the likelihood ratio test, told what to look for.
    """
    return float(ncx2.sf(chi2.isf(level, freedom), freedom, max(strength, 1e-9) ** 2))


def by_strength(scores: Sequence[CaseScore]) -> list[PowerRow]:
    """Return detection against strength for lone effects of the table whose strength is known."""
    known = [
        (s.strength[0], max(s.freedom[0], 1), s.alarm) for s in scores if s.kind == "one" and s.strength[0] is not None
    ]
    rows = []
    for low, high in STRENGTHS:
        here = [(v, df, alarm) for v, df, alarm in known if low <= v < high]
        if here:
            hits = sum(alarm for _, _, alarm in here)
            theory = float(np.mean([power(v, df) for v, df, _ in here]))
            rows.append(PowerRow(low, high, len(here), hits, wilson(hits, len(here)), theory))
    return rows
