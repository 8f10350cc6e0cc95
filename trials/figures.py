"""Figures over many cases, with Wilson intervals and verdicts against what is aimed at."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np
from scipy.stats import chi2, ncx2

from imubench.toml_file import parse_toml
from imubench.trials.scoring import CaseScore

Z95 = 1.959964
LEVEL = 0.01  # false alarms of the test that the theoretical power belongs to
STRENGTHS = ((0.0, 2.0), (2.0, 4.0), (4.0, 6.5), (6.5, 10.0), (10.0, 30.0), (30.0, float("inf")))
BELIEFS = ((0.0, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 0.97), (0.97, 1.0001))
MOUNTS = ("soft_mount", "rocking_mount")
STRANGE = 10.0  # standard deviations from every name, from which physics outside the table shows as such


@dataclass(frozen=True)
class Figure:
    """A figure, what it is aimed to be, and what came of that."""

    name: str
    title: str
    value: float | None  # None: no case asks for it
    n: int  # cases, findings or numbers that it is counted over
    hits: int | None = None  # of a share
    interval: tuple[float, float] | None = None  # 95 %
    aim: str = ""
    verdict: str = ""  # holds; open: missed, but n is too small to tell; fails; none
    guard: str = ""  # the limit that must not be passed
    passed: bool = False  # whether it is


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


def reliability(scores: Sequence[CaseScore]) -> list[dict[str, Any]]:
    """Return, for findings by stated confidence, how many of them are true."""
    beliefs = [b for s in scores for b in s.beliefs]
    rows: list[dict[str, Any]] = []
    for low, high in BELIEFS:
        here = [(c, t) for c, t in beliefs if low <= c < high]
        if here:
            hits, n = sum(t for _, t in here), len(here)
            stated = float(np.mean([c for c, _ in here]))
            row: dict[str, Any] = {"from": low, "to": min(high, 1.0), "stated": stated, "n": n, "true": hits}
            rows.append(row | {"interval": list(wilson(hits, n))})
    return rows


def figures(scores: Sequence[CaseScore]) -> list[Figure]:
    """Return every figure of limits.toml, in its order, judged."""
    limits = parse_toml((files("imubench.trials") / "limits.toml").read_bytes(), "limits.toml")["figure"]
    return [judged(limit, *FIGURES[limit["name"]](scores)) for limit in limits]


Counted = tuple[float | None, int, int | None]
"""Value, n, hits."""


def judged(limit: dict[str, Any], value: float | None, n: int, hits: int | None) -> Figure:
    """Return a figure with the verdict on its aim, and whether its guard is passed."""
    interval = wilson(hits, n) if hits is not None and n else None
    verdict, passed = "none", False
    if value is not None and "aim" in limit:
        good = _within(value, limit["aim"])
        favourable = interval is not None and interval[0] <= limit["aim"][1] and limit["aim"][0] <= interval[1]
        verdict = "holds" if good else "open" if favourable else "fails"
    if value is not None and "guard" in limit:
        passed = not _within(value, limit["guard"])
    texts = {key: _text(limit[key]) if key in limit else "" for key in ("aim", "guard")}
    return Figure(
        limit["name"], limit["title"], value, n, hits, interval, texts["aim"], verdict, texts["guard"], passed
    )


def _within(value: float, limit: list[float]) -> bool:
    return limit[0] <= value <= limit[1]


def _text(limit: list[float]) -> str:
    low, high = limit
    if low == float("-inf") or (low == 0 and high < float("inf")):
        return f"<= {high:g}"
    return f">= {low:g}" if high in (1.0, float("inf")) else f"{low:g} to {high:g}"


def numbers(f: Figure) -> tuple[str, str]:
    """Return a figure and its interval as text."""
    if f.value is None:
        return "-", ""
    if f.hits is None:
        return f"{f.value:.3g}", ""
    low, high = f.interval or (0.0, 1.0)
    return f"{100 * f.value:.0f} %", f"{100 * low:.0f} - {100 * high:.0f} %"


def share(answers: Iterable[bool | None]) -> Counted:
    """Return the share of yes among the cases in which the question arises."""
    asked = [bool(a) for a in answers if a is not None]
    return (sum(asked) / len(asked) if asked else None), len(asked), sum(asked)


def middle(values: Iterable[float | None]) -> Counted:
    """Return the median of the values that are there."""
    there = [v for v in values if v is not None]
    return (float(np.median(there)) if there else None), len(there), None


def _silent(noise: str) -> Callable[[Sequence[CaseScore]], Counted]:
    return lambda scores: share(
        s.alarm for s in scores if s.kind == "none" and s.observable and s.noise == noise and not s.failed
    )


def _power(low: float, high: float) -> Callable[[Sequence[CaseScore]], Counted]:
    return lambda scores: share(
        s.alarm
        for s in scores
        if s.kind == "one" and s.observable and s.strength[0] is not None and low <= s.strength[0] < high
    )


def _behind_theory(scores: Sequence[CaseScore]) -> Counted:
    """Return by how much detection near 5 times the bound is below theory."""
    row = next((r for r in by_strength(scores) if r.low == 4.0), None)
    return (None, 0, None) if row is None else (row.theory - row.hits / row.n, row.n, None)


def _over_bound(mounts: bool) -> Callable[[Sequence[CaseScore]], Counted]:
    """Return the median over findings of the RMS parameter error over its bound."""

    def counted(scores: Sequence[CaseScore]) -> Counted:
        per_case = []
        for s in scores:
            ratios = [r for e in s.errors if e.over_bound and (e.effect in MOUNTS) == mounts for r in e.over_bound]
            per_case.append(float(np.sqrt(np.mean(np.square(ratios)))) if ratios else None)
        return middle(per_case)

    return counted


def _covered(scores: Sequence[CaseScore]) -> Counted:
    return share(abs(z) <= Z95 for s in scores for e in s.errors for z in e.over_std)


def _of_effects(counts: Sequence[tuple[int, int]]) -> Counted:
    """Return the share of effects with a hit, from the hits and effects of each case."""
    hits, n = sum(hit for hit, _ in counts), sum(there for _, there in counts)
    return (hits / n if n else None), n, hits


def strange(score: CaseScore) -> bool:
    """Return whether physics outside the table is so far from every name that a recording shows it."""
    return score.beyond is not None and score.beyond >= STRANGE


FIGURES: dict[str, Callable[[Sequence[CaseScore]], Counted]] = {
    "answered": lambda scores: share(not s.failed for s in scores),
    "false_alarms_white": _silent("white"),
    "false_alarms_coloured": _silent("coloured"),
    "false_alarms_misdeclared": _silent("misdeclared"),
    "silent": lambda scores: share(
        not s.alarm for s in scores if s.kind == "none" and s.observable and s.noise != "real" and not s.failed
    ),
    "behind_theory": _behind_theory,
    "detected_strong": _power(10.0, float("inf")),
    "first_right": lambda scores: share(s.first_right for s in scores),
    "in_set": lambda scores: share(s.in_set for s in scores),
    "set_size": lambda scores: (
        (float(np.mean(sizes)), len(sizes), None)
        if (sizes := [s.set_size for s in scores if s.set_size is not None])
        else (None, 0, None)
    ),
    "exact_sets": lambda scores: share(s.exact for s in scores),
    "confidently_wrong": lambda scores: share(bool(s.wrong) for s in scores),
    "outside_flagged": lambda scores: share(s.flagged for s in scores),
    "outside_located": lambda scores: share(s.located for s in scores),
    "strange_flagged": lambda scores: share(s.flagged for s in scores if strange(s)),
    "strange_located": lambda scores: share(s.located for s in scores if strange(s)),
    "error_over_bound": _over_bound(mounts=False),
    "error_over_bound_mounts": _over_bound(mounts=True),
    "covered": _covered,
    "excess_removed": lambda scores: middle(s.removed for s in scores),
    "unobservable_said": lambda scores: share(
        s.verdict in ("unobservable", "no mismatch") for s in scores if not s.observable
    ),
    "real_silent": _silent("real"),
    "real_located": lambda scores: _of_effects([(s.pointed, len(s.truth)) for s in scores if s.noise == "real"]),
    "real_named": lambda scores: _of_effects([(s.named, len(s.truth)) for s in scores if s.noise == "real"]),
    "seconds": lambda scores: middle(s.seconds for s in scores),
}
"""What is counted, by its name in limits.toml."""
