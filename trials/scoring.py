"""One diagnosis against the opened truth of its case."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any

from imubench.diagnosis.result import Diagnosis, Finding, Verdict
from imubench.trials.match import ParameterError, holds, inside, names, paired, parameter_errors, sure, true
from imubench.trials.replayed import Replayed
from imubench.trials.seal import Truth

CONFIDENT = 0.9
MISDECLARED = 0.05  # of the noise std, from which a declared level counts as wrong
EXCESS = 0.05  # of the held-out misfit above 1, under which there is nothing to remove
VISIBLE = 5.0  # times its bound, from which a missed effect is a failure of the diagnosis, not of the data


@dataclass(frozen=True)
class CaseScore:
    """What one diagnosis was worth. None: the question does not arise in this case."""

    name: str
    kind: str  # none, one, several, outside
    rig: str
    observable: bool
    noise: str  # white, coloured, misdeclared, real
    truth: list[str]  # "effect at place"
    strength: list[float | None]  # over the Cramer-Rao bound
    freedom: list[int]  # numbers that an effect has
    seconds: float
    beyond: float | None = None  # standard deviations of physics outside the table from the nearest name
    least: float | None = None  # the same in the least favourable noise
    failed: str = ""  # why there is no diagnosis
    verdict: str = ""
    found: tuple[str, ...] = ()  # sure ones, "effect at place (confidence)"
    alarm: bool = False  # whether anything is said to be there
    loud: bool = False  # whether the declared model's misfit alone would raise an alarm
    first_right: bool | None = None  # the strongest finding names a lone effect
    in_set: bool | None = None  # a lone effect is the strongest finding or one of its equivalents
    set_size: int | None = None
    named: int = 0  # effects with a finding of their own
    pointed: int = 0  # effects at whose place something is found, named or not
    exact: bool | None = None  # all of several effects and nothing else
    wrong: tuple[str, ...] = ()  # named with confidence 0.9 or more, and not there
    beliefs: tuple[tuple[float, bool], ...] = ()  # every finding's confidence, and whether it is true
    flagged: bool | None = None  # physics outside the table came out as unknown
    located: bool | None = None  # and that at its place
    errors: tuple[ParameterError, ...] = ()
    removed: float | None = None  # share of the held-out excess that the findings remove
    replayed: Replayed = field(default_factory=Replayed)  # what its simulations were worth


def asked(name: str, truth: Truth, seconds: float) -> dict[str, Any]:
    """Return what a score says of the case itself."""
    options = truth["options"]
    off = abs(options["misdeclared"]) if options["declare_noise"] else 0.0
    level = "misdeclared" if off >= MISDECLARED else "white"
    return {
        "name": name,
        "kind": truth["kind"],
        "rig": truth["rig"],
        "observable": truth["observable"],
        "noise": truth.get("noise") or ("coloured" if options["colour"] > 0 else level),
        "truth": truth.get("told") or [f"{e['effect']} at {e['at']}" for e in truth["effects"]],
        "strength": truth["visibility"],
        "freedom": truth["freedom"],
        "seconds": seconds,
        "beyond": neighbour["beyond"] if (neighbour := truth.get("neighbour")) else None,
        "least": neighbour["least"] if neighbour else None,
    }


def failed(name: str, truth: Truth, seconds: float, why: str) -> CaseScore:
    """Return the score of a case without a diagnosis: nothing found, nothing right."""
    kind = truth["kind"]
    return CaseScore(
        **asked(name, truth, seconds),
        failed=why or "no reason given",
        exact=False if kind == "several" else None,
        flagged=False if kind == "outside" else None,
        located=False if kind == "outside" else None,
    )


def score(name: str, truth: Truth, d: Diagnosis, seconds: float, alarm_misfit: float) -> CaseScore:
    """Return what a diagnosis was worth; `alarm_misfit`: the misfit from which its size alone is an alarm."""
    kind, found = truth["kind"], sure(d.findings)
    pairs = paired(truth, found)
    lone = kind == "one" and truth["observable"]
    first = found[0] if found else None
    outside = kind == "outside"
    return CaseScore(
        **asked(name, truth, seconds),
        verdict=d.verdict,
        found=tuple(f"{f.effect} at {f.at} ({f.confidence:.2f})" for f in found),
        alarm=bool(found),
        loud=d.misfit[0] > alarm_misfit,
        first_right=names(truth["answers"][0], first.effect, first.at) if lone and first else None,
        in_set=holds(truth["answers"][0], first) if lone and first else None,
        set_size=1 + len(first.equivalent) if lone and first else None,
        named=len(pairs),
        pointed=sum(any(f.at == a["at"] for f in found for a in answers) for answers in truth["answers"]),
        exact=exact(truth, found, pairs) if kind == "several" else None,
        wrong=tuple(f"{f.effect} at {f.at}" for f in found if confidently_wrong(truth, found, f)),
        beliefs=tuple((round(f.confidence, 4), true(truth, d.findings, f)) for f in d.findings),
        flagged=any(not f.named for f in found) if outside else None,
        located=any(not f.named and f.at == truth["effects"][0]["at"] for f in found) if outside else None,
        errors=tuple(e for i, f in pairs.items() for e in parameter_errors(truth, i, f)),
        removed=removed(d) if truth["effects"] and any(f.named for f in found) else None,
    )


def exact(truth: Truth, found: Sequence[Finding], pairs: dict[int, Finding]) -> bool:
    """Return whether every effect has a finding of its own, and no finding is left over."""
    return len(pairs) == len(inside(truth)) == len(found)


def verdict_of(findings: Sequence[Finding], noise_unknown: Collection[str] = ()) -> Verdict:
    """Return the verdict that goes with some findings of a diagnosis, of sensors of which some noise may be unknown."""
    named, unnamed = ([f for f in sure(findings) if f.named == is_named] for is_named in (True, False))
    if named:
        return "partly explained" if unnamed or noise_unknown else "explained"
    return "unexplained" if unnamed else "no mismatch"


def confidently_wrong(truth: Truth, found: Sequence[Finding], finding: Finding) -> bool:
    """Return whether a finding names with great confidence what is not there."""
    return finding.named and finding.confidence >= CONFIDENT and not true(truth, found, finding)


def removed(d: Diagnosis) -> float | None:
    """Return the share of the held-out misfit above noise that is gone; None where there was hardly any."""
    before, after = d.fit.heldout
    return None if before - 1 < EXCESS else (before - after) / (before - 1)


def missed(s: CaseScore) -> bool:
    """Return whether nothing was said of a lone effect that a test at the bound would see."""
    strength = s.strength[0] if s.strength else None
    return s.kind == "one" and s.observable and not s.alarm and strength is not None and strength >= VISIBLE
