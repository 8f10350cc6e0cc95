"""What a check found, in plain sentences: the same in the console, the summary, the JUnit file and pytest."""

import math
from collections.abc import Sequence

from imubench.checks.check import Checked
from imubench.checks.claim import Claim
from imubench.checks.decide import Decision
from imubench.errors import shortened

LONGEST = 200
"""Characters of the finding: a heading of two lines."""


def finding(done: Sequence[Checked]) -> str:
    """Return the outcome of a check in a line, with the names of what does not hold."""
    decisions = [d for one in done for d in one.decisions]
    failed, undecided = ([d for d in decisions if d.verdict == v] for v in ("fails", "undecided"))
    if not failed and not undecided:
        return "the claim holds" if len(decisions) == 1 else f"all {len(decisions)} claims hold"
    counts = ((len(failed), "fails", "fail"), (len(undecided), "is undecided", "are undecided"))
    told = [(count, one if count == 1 else many) for count, one, many in counts if count]
    (first, verb), *rest = told
    subject = "the claim" if len(decisions) == 1 else f"{first} of {len(decisions)} claims"
    also = "".join(f", {count} {what}" for count, what in rest)
    names = ", ".join(title(d) for d in (*failed, *undecided))
    return shortened(f"{subject} {verb}{also}: {names}", LONGEST)


def title(decision: Decision) -> str:
    """Return the name of what was decided."""
    return decision.claim.name + (" beside the baseline" if decision.baseline is not None else "")


def sentence(decision: Decision) -> str:
    """Return what is claimed."""
    claim = decision.claim
    if decision.baseline is None:
        return claim.sentence
    subject = f"{claim.figure} of {claim.named} on {claim.scenario.name}"
    return f"{subject}: not {_percent(claim.margin)} worse than the baseline"


def measured(decision: Decision) -> str:
    """Return what came out, and of how many runs."""
    claim, runs = decision.claim, _runs(decision.runs)
    if not decision.runs:
        return "no run to compare"
    if decision.baseline is not None:
        return f"errors {decision.measured:.3g} times the baseline's, the median of {runs}"
    if math.isinf(decision.measured):
        return f"no {claim.over} over {runs}, for an estimate is missing"
    if claim.over == "share":
        return f"within {claim.bound} in {_percent(decision.measured)} of {runs}"
    return f"{claim.over} {claim.bound.shown(decision.measured)} over {runs}"


def troubles(decision: Decision) -> str:
    """Return in how many runs there was no estimate, and why in the first; empty where there always was one."""
    if decision.why_undecided:
        return decision.why_undecided
    if not decision.missing or decision.baseline is not None:
        return ""
    number, why = decision.missing[0]
    return f"no such figure in {len(decision.missing)} of {_runs(decision.runs)}; run {number}: {why}"


def sureness(claim: Claim, broken: str, power: float) -> str:
    """Return the two error rates of a claim's test; `broken` is what they call broken, passed with 1 - `power`."""
    return (
        f"a true claim fails with a probability of at most {_percent(1 - claim.confidence)}, "
        f"a broken one ({broken}) holds with at most {_percent(1 - power)}"
    )


def rates(decision: Decision) -> str:
    """Return the two error rates of what was decided."""
    claim = decision.claim
    if decision.baseline is None:
        return sureness(claim, claim.broken, claim.power)
    return sureness(claim, f"errors {_percent(claim.margin)} larger or more", claim.baseline_power)


def paragraph(decision: Decision) -> str:
    """Return all of it, as a failure is told."""
    lines = [f"{decision.verdict}: {sentence(decision)}", measured(decision), troubles(decision), rates(decision)]
    return "\n".join(line for line in lines if line)


def _runs(count: int) -> str:
    return f"{count} run{'s' * (count != 1)}"


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"
