"""What may be said where the time limit came first: no more than what was tried bears out."""

from collections.abc import Collection

import numpy as np

from imubench.diagnosis.budget import Budget
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.residual_checks.fit_summary import Weighed, traces
from imubench.diagnosis.residual_checks.localize import locate
from imubench.diagnosis.result import UNKNOWN, Doubt, Finding, Interval, Unseen, Verdict, Where
from imubench.diagnosis.search.confidence import DOUBTFUL, at_most
from imubench.diagnosis.verdict.posterior import verdict_of

HALVES_AGREE = "whether the halves of the recording agree"
NAMELESS_TERMS = "terms without a name for what no effect explains"
MORE_TIME = "no other motion: the same recording with a longer --time-limit, or a part of it"


def doubted_as_stopped(fitted: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Return findings of a search that was stopped: what else they may be was not tried."""
    return tuple(at_most(f, DOUBTFUL) for f in fitted)


def with_rest(
    rest: tuple[Finding, ...], after: Weighed, allowed: float = ADMISSION.unexplained_misfit
) -> tuple[Finding, ...]:
    """Return what has no name, with what a fit leaves where that is too much for noise and nothing else says so."""
    if any(f.effect == UNKNOWN for f in rest) or max(after.misfit, after.left_out) <= allowed:
        return rest
    found = locate(traces(after), {})
    place = found[0] if found else _loudest(after)
    nothing = Interval(0.0, (0.0, 0.0))
    return (*rest, Finding(UNKNOWN, place.at, DOUBTFUL, {}, nothing, where=place))


def _loudest(after: Weighed) -> Where:
    """Return the sensor that leaves most, where no channel stands out."""
    worst = max(traces(after), key=lambda t: float(np.mean(t.whitened**2)))
    channel = worst.channels[int(np.argmax(np.sum(worst.before**2, axis=0)))]
    return Where(worst.at, {channel: 1.0}, (), (), "nothing clear", 1.0)


def verdict_when_stopped(
    named: tuple[Finding, ...],
    rest: tuple[Finding, ...],
    after: Weighed,
    noise_unknown: Collection[str] = (),
    doubted: bool = False,
) -> tuple[Verdict, tuple[Unseen, ...]]:
    """Return the verdict of a diagnosis that was stopped, and what it could not show.

    That there is no mismatch it cannot say: an effect may leave a misfit of 1 and show to the search alone. Explained
    is what findings bring back to the noise, on data that they have not seen too, however they may be called.
    """
    verdict = verdict_of(named, rest, noise_unknown, doubted)
    if verdict != "no mismatch":
        return verdict, ()
    what = f"whether an effect is there: the misfit of {after.misfit:.2f} is noise's, but not every effect was tried"
    return "unobservable", (Unseen(what, MORE_TIME),)


def not_asked(what: str) -> Doubt:
    """Return the doubt about a model that was not asked in time what a model must be asked before it is used."""
    return Doubt("the model", f"there was no time to ask {what}")


def not_fitted(budget: Budget) -> tuple[Unseen, ...]:
    """Return what a recording could not show whose motion was not fitted in time."""
    return (Unseen(f"anything: its motion was not fitted within the {budget.stopped}", MORE_TIME),)


__all__ = [
    "HALVES_AGREE",
    "NAMELESS_TERMS",
    "doubted_as_stopped",
    "not_asked",
    "not_fitted",
    "verdict_when_stopped",
    "with_rest",
]
