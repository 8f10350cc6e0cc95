"""What is counted over many cases, by its name in limits.toml."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from imubench.diagnosis.search.moves.swap_for_term import NAMES
from imubench.trials.detection import LEVEL, Z95, by_strength, power
from imubench.trials.replayed import Replayed
from imubench.trials.scoring import CaseScore

MOUNTS = ("soft_mount", "rocking_mount")
STRANGE = 10.0  # standard deviations from every name, from which physics outside the table shows as such

Counted = tuple[float | None, int, int | None]
"""Value, n, hits."""


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


def _possible(distance: Callable[[CaseScore], float | None]) -> Callable[[Sequence[CaseScore]], Counted]:
    """Return the share of physics outside the table that a search which shares LEVEL among all names would flag.

    It is told the shape and the noise's level; `distance` is how many standard deviations the physics is from the
    nearest name. What has no distance counts as seen.
    """

    def counted(scores: Sequence[CaseScore]) -> Counted:
        asked = [(distance(s), max(s.freedom[0], 1)) for s in scores if s.kind == "outside"]
        seen = [1.0 if far is None else power(far, freedom, LEVEL / NAMES) for far, freedom in asked]
        return (float(np.mean(seen)) if seen else None), len(seen), None

    return counted


def _of_replays(
    question: Callable[[Replayed], bool | None], kinds: tuple[str, ...]
) -> Callable[[Sequence[CaseScore]], Counted]:
    """Return the share of yes to a question of the simulations, in cases of some kinds."""
    return lambda scores: share(question(s.replayed) for s in scores if s.kind in kinds)


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
    "outside_possible": _possible(lambda s: s.beyond),
    "outside_possible_least": _possible(lambda s: s.least),
    "strange_flagged": lambda scores: share(s.flagged for s in scores if strange(s)),
    "strange_located": lambda scores: share(s.located for s in scores if strange(s)),
    "error_over_bound": _over_bound(mounts=False),
    "error_over_bound_mounts": _over_bound(mounts=True),
    "covered": _covered,
    "excess_removed": lambda scores: middle(s.removed for s in scores),
    "unobservable_said": lambda scores: share(
        s.verdict in ("unobservable", "no mismatch") for s in scores if not s.observable
    ),
    "modelled": _of_replays(lambda r: None if r.rolled_out else r.modelled, ("one",)),
    "modelled_several": _of_replays(lambda r: None if r.rolled_out else r.modelled, ("several",)),
    "modelled_swings": _of_replays(lambda r: r.modelled if r.rolled_out else None, ("one", "several")),
    "shown": _of_replays(lambda r: r.shown, ("one",)),
    "shown_several": _of_replays(lambda r: r.shown, ("several",)),
    "where_sensor": _of_replays(lambda r: r.sensor, ("one", "several")),
    "where_channel": _of_replays(lambda r: r.first_channel, ("one", "several")),
    "real_silent": _silent("real"),
    "real_located": lambda scores: _of_effects([(s.pointed, len(s.truth)) for s in scores if s.noise == "real"]),
    "real_named": lambda scores: _of_effects([(s.named, len(s.truth)) for s in scores if s.noise == "real"]),
    "seconds": lambda scores: middle(s.seconds for s in scores),
}
