"""Figures over many cases, with Wilson intervals and verdicts against what is aimed at."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from imubench.inputs.toml import parse_toml
from imubench.trials.counted import FIGURES
from imubench.trials.detection import wilson
from imubench.trials.scoring import CaseScore

BELIEFS = ((0.0, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 0.97), (0.97, 1.0001))


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
    limits = parse_toml((files("imubench.trials") / "limits.toml").read_bytes(), "limits.toml", finite=False)["figure"]
    return [judged(limit, *FIGURES[limit["name"]](scores)) for limit in limits]


def judged(limit: dict[str, Any], value: float | None, n: int, hits: int | None) -> Figure:
    """Return a figure with the verdict on its aim, and whether its guard is broken."""
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
