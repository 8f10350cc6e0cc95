"""From a file of claims to their verdicts: runs are added until every claim is decided."""

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from time import monotonic

from imubench.checks.baseline import Baseline
from imubench.checks.claim import Claim
from imubench.checks.decide import Decision, about_the_bound, beside_the_baseline
from imubench.checks.runs import Runs, Subject
from imubench.progress import Report


@dataclass(frozen=True)
class Checked:
    """A claim with what was decided about it."""

    claim: Claim
    first: int  # number of the first run
    errors: tuple[float, ...]  # rad or m, of all its runs in order, inf without an estimate
    bound: Decision
    baseline: Decision | None  # None: there was none
    same_recordings: bool = True  # whether the baseline's runs are of the same recordings
    seconds: float = 0.0  # by the clock; those of runs that claims share are divided among them

    @property
    def decisions(self) -> tuple[Decision, ...]:
        """That about the bound, and that beside the baseline where there is one."""
        return (self.bound,) if self.baseline is None else (self.bound, self.baseline)

    @property
    def holds(self) -> bool:
        """Whether everything about it holds."""
        return all(decision.verdict == "holds" for decision in self.decisions)


def check(
    claims: Sequence[Claim],
    runs: Runs,
    first: int = 0,
    baselines: Mapping[str, Baseline] | None = None,
    least: int = 0,
    report: Report = lambda *_: None,
) -> list[Checked]:
    """Return what runs from number `first` on say about each claim.

    Claims about the same estimator on the same scenario share their runs. Each is decided as soon as it can be, and
    by the same runs whatever the others need.

    Args:
        claims: the claims.
        runs: where runs come from.
        first: number of the first run.
        baselines: earlier errors by the name of the claim; a claim without is held against its bound alone.
        least: how many runs are made at least, decided or not; for a file that shall serve as a baseline.
        report: told how far it is.

    Raises:
        InputError: as `runs.played`, and for a figure that the estimator's answers do not have.
    """
    by_subject: dict[Subject, list[Claim]] = {}
    for claim in claims:
        by_subject.setdefault(Subject(claim.estimator, claim.scenario, claim.time_limit), []).append(claim)
    done = {}
    for subject, some in by_subject.items():
        for one in _of_one(subject, some, runs, first, baselines or {}, least, report):
            done[one.claim.name] = one
    return [done[claim.name] for claim in claims]


def _of_one(
    subject: Subject,
    claims: Sequence[Claim],
    runs: Runs,
    first: int,
    baselines: Mapping[str, Baseline],
    least: int,
    report: Report,
) -> list[Checked]:
    bounds = {c.name: about_the_bound(c) for c in claims}
    beside = {c.name: beside_the_baseline(c, baselines[c.name].errors) if c.name in baselines else None for c in claims}
    decisions = [*bounds.values(), *(d for d in beside.values() if d is not None)]
    errors: dict[str, list[float]] = {c.name: [] for c in claims}
    what, most = ", ".join(c.name for c in claims), max(least, *(c.max_runs for c in claims))
    began = monotonic()
    with closing(runs.of(subject, first)) as outcomes:
        for i, outcome in enumerate(outcomes):
            for decision in decisions:
                decision.add(first + i, outcome)
            for c in claims:
                errors[c.name].append(bounds[c.name].claim_error(outcome))
            report(what, i + 1, most)
            if i + 1 >= least and all(d.verdict is not None for d in decisions):
                break
    return [
        Checked(
            *(c, first, tuple(errors[c.name]), bounds[c.name], beside[c.name]),
            same_recordings=c.name not in baselines or baselines[c.name].same_simulation,
            seconds=(monotonic() - began) / len(claims),
        )
        for c in claims
    ]
