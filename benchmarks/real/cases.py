"""The cases of the suite: which stretch of which recording is diagnosed. No stretch is chosen by what is in it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import pairwise

import numpy as np

from benchmarks.real.sources import Source

SHORT, SHORT_STEP = 20.0, 10.0  # s: windows of screwed-on IMUs, every 10 s from the first sample on
LONG = 40.0  # s: windows of `broad`, one after the other from the first sample on
LEARNED = 2  # the window of `broad` whose diagnosis is a baseline, and that is diagnosed with one: 80 to 120 s
UNDISTURBED = "undisturbed"


@dataclass(frozen=True)
class Case:
    """A stretch of a recording, named source/part."""

    source: Source
    part: str
    start: float  # s since the recording's first sample
    end: float
    baseline: str = ""  # the case whose diagnosis says what is known of the sensors

    @property
    def name(self) -> str:
        return f"{self.source.name}/{self.part}"


def cases(found: Sequence[Source]) -> list[Case]:
    """Return every case of some recordings; one with a baseline comes after those without."""
    plain = [case for source in found for case in _plain(source)]
    return [*plain, *_with_baselines(plain)]


def chosen(every: Sequence[Case], patterns: Sequence[str]) -> list[Case]:
    """Return the cases whose names match a shell pattern, or all without one, and the baselines that they need."""
    if not patterns:
        return list(every)
    matching = [c for c in every if any(fnmatchcase(c.name, p) for p in patterns)]
    needed = {c.baseline for c in matching}
    return [c for c in every if c in matching or c.name in needed]


def _plain(source: Source) -> Iterator[Case]:
    kind = source.name.partition("/")[0]
    if kind == "broad":
        yield from (Case(source, part, *span) for part, span in windows(source.seconds, LONG, LONG))
        return
    yield Case(source, "whole", 0.0, source.seconds)
    if kind in ("diodem", "dot-knee"):
        yield from (Case(source, f"half{i + 1}", *span) for i, span in enumerate(parts(source.seconds, 2)))
    if kind == "diodem":
        yield from (Case(source, f"third{i + 1}", *span) for i, span in enumerate(parts(source.seconds, 3)))
        if source.name.endswith("rigid"):
            yield from (Case(source, part, *span) for part, span in windows(source.seconds, SHORT, SHORT_STEP))


def _with_baselines(plain: Sequence[Case]) -> Iterator[Case]:
    """Yield one window of every trial of `broad` with what each undisturbed other one says of the same window."""
    learned = f"{LEARNED * LONG:.0f}-{(LEARNED + 1) * LONG:.0f}"
    broad = [c for c in plain if c.source.name.startswith("broad/") and c.part == learned]
    for case in broad:
        for other in broad:
            trial = other.source.name.removeprefix("broad/")
            if other is not case and UNDISTURBED in trial:
                yield Case(case.source, f"{learned}-after-{trial[:2]}", case.start, case.end, other.name)


def parts(seconds: float, count: int) -> list[tuple[float, float]]:
    """Return a number of stretches of equal length, in s, that make up the whole."""
    return [(float(a), float(b)) for a, b in pairwise(np.linspace(0.0, seconds, count + 1))]


def windows(seconds: float, length: float, step: float) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield the names and the stretches, in s, of all windows of a length that lie in the whole, from 0 on."""
    start = 0.0
    while start + length <= seconds:
        yield f"{start:.0f}-{start + length:.0f}", (start, start + length)
        start += step
