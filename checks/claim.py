"""Claims as their author writes them: an estimator, a scenario, a figure with its bound, and how sure to be."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from imubench.checks.evidence import Evidence, MeanTest, MedianTest, ShareTest
from imubench.checks.figures import Bound, check_figure, parse_bound
from imubench.checks.scenario import Scenario, own_scenarios, parse_scenario
from imubench.dataset.ranges import check_keys, chosen, number
from imubench.errors import InputError, shown
from imubench.inputs.files import read_bytes
from imubench.inputs.toml import parse_toml
from imubench.plugin_versions import absolute
from imubench.plugins import find_estimator

Over = Literal["rms", "mean", "median", "share"]
OVER = ("rms", "mean", "median")
SHARED: Mapping[str, object] = {
    "estimator": None,
    "scenario": None,
    "over": "rms",
    "margin": 0.2,
    "confidence": 0.99,
    "power": 0.99,
    "baseline_power": 0.9999,
    "max_runs": 1000,
    "time_limit": 60.0,
}
"""Keys of a claim that the file may say once for all of its claims, and what holds where neither says it."""
OWN = ("claim", "figure", "at_most", "at_least", "broken_at")


@dataclass(frozen=True)
class Claim:
    """A sentence about an estimator that runs can confirm or refute."""

    name: str
    sentence: str
    estimator: str  # as `find_estimator` takes it, files with an absolute path
    named: str  # the estimator as its author named it
    scenario: Scenario
    figure: str  # of imubench.score
    bound: Bound
    over: Over  # what of the errors over runs: `share` is that of the runs within the bound
    at_least: float  # the share that is claimed, where it is one
    broken_at: float  # the share at which the claim counts as broken
    margin: float  # beyond the bound, or beyond a baseline, by which the claim counts as broken
    confidence: float  # 1 - the probability that a true claim fails
    power: float  # 1 - the probability that a broken claim is passed
    baseline_power: float  # the same beside a baseline, of errors that are larger by the margin
    max_runs: int
    time_limit: float  # s for one estimate of an estimator from outside

    @property
    def evidence(self) -> Evidence:
        """The evidence for and against it, without any run yet."""
        if self.over == "share":
            return ShareTest(self.bound.si, self.at_least, self.broken_at)
        if self.over == "median":
            return MedianTest(self.bound.si, self.margin)
        return MeanTest(self.bound.si, self.margin, 2 if self.over == "rms" else 1)

    @property
    def broken(self) -> str:
        """In words, what it counts as broken."""
        if self.over == "share":
            return f"only {100 * self.broken_at:.3g} % of the runs within {self.bound}"
        return f"{self.bound.shown(self.bound.si * (1 + self.margin))} or more"

    @property
    def asked(self) -> str:
        """The bound in words."""
        if self.over == "share":
            return f"<= {self.bound} in at least {100 * self.at_least:.3g} % of the runs"
        return f"{self.over} <= {self.bound}"


def load_claims(path: Path, estimator: str | None = None) -> tuple[Claim, ...]:
    """Return the claims of a TOML file; `InputError` says in one line what is wrong with it.

    Args:
        path: the file.
        estimator: take this one for all claims, whatever the file says.
    """
    return parse_claims(read_bytes(path), path, estimator)


def parse_claims(content: bytes, path: Path, estimator: str | None = None) -> tuple[Claim, ...]:
    """Return the claims in the bytes of a file at `path`, beside which the files that they name lie."""
    where = path.name
    file = parse_toml(content, str(path))
    check_keys(file, ("format", "claim", "scenarios", *SHARED), where)
    if file.get("format", 1) != 1:
        raise InputError(f"{where}: format: expected 1, got {shown(file['format'])}")
    claims = file.get("claim")
    if not isinstance(claims, dict) or not claims or not all(isinstance(t, dict) for t in claims.values()):
        raise InputError(f"{where}: expected one [claim.NAME] table or more, got {shown(claims)}")
    shared = {key: file[key] for key in SHARED if key in file}
    own = own_scenarios(file.get("scenarios", {}), f"{where}: scenarios")
    if estimator is not None:
        shared["estimator"] = estimator
    return tuple(
        _claim(name, table, {**SHARED, **shared}, own, path, f"{where}: claim.{name}", estimator)
        for name, table in claims.items()
    )


def _claim(
    name: str,
    table: Mapping[str, Any],
    shared: Mapping[str, Any],
    own: Mapping[str, Mapping[str, Any]],
    path: Path,
    where: str,
    forced: str | None,
) -> Claim:
    check_keys(table, (*OWN, *SHARED), where)
    values = {**shared, **table}
    if not name.isprintable() or not name.strip():
        raise InputError(f"{where}: expected a printable name")
    for key in ("estimator", "scenario", "figure", "at_most"):
        if values.get(key) is None:
            raise InputError(f"{where}: expected the key '{key}', got {', '.join(table) or 'none'}")
    named = forced or values["estimator"]
    if not isinstance(named, str):
        raise InputError(f"{where}.estimator: expected a name, file.py:function or module:function, got {shown(named)}")
    estimator = named if forced else absolute(named, path.parent)
    found = find_estimator(estimator)
    figure = check_figure(values["figure"], found.quantity, named, where)
    bound = parse_bound(values["at_most"], figure, f"{where}.at_most")
    share = "at_least" in table
    if share and "over" in table:
        raise InputError(f"{where}: expected 'over' or 'at_least', got both")
    if "broken_at" in table and not share:
        raise InputError(f"{where}.broken_at: expected it with 'at_least', got it alone")
    at_least = _fraction(table.get("at_least", 0.9), f"{where}.at_least")
    broken_at = _fraction(table.get("broken_at", odds_of_a_bad_run_doubled(at_least)), f"{where}.broken_at")
    if broken_at >= at_least:
        raise InputError(f"{where}.broken_at: expected less than at_least = {at_least:g}, got {broken_at:g}")
    over: Any = "share" if share else chosen(values["over"], f"over in {where}", OVER)
    claim = Claim(
        name=name,
        sentence="",
        estimator=estimator,
        named=named,
        scenario=parse_scenario(values["scenario"], own, path.parent, f"{where}.scenario"),
        figure=figure,
        bound=bound,
        over=over,
        at_least=at_least,
        broken_at=broken_at,
        margin=number(values["margin"], f"{where}.margin", 0.01, 10.0),
        confidence=_fraction(values["confidence"], f"{where}.confidence", 0.5),
        power=_fraction(values["power"], f"{where}.power", 0.5),
        baseline_power=_fraction(values["baseline_power"], f"{where}.baseline_power", 0.5),
        max_runs=_count(values["max_runs"], f"{where}.max_runs"),
        time_limit=number(values["time_limit"], f"{where}.time_limit", open_low=True),
    )
    return _said(claim, table.get("claim"), where)


def _said(claim: Claim, sentence: object, where: str) -> Claim:
    """Return a claim with its author's sentence, or with one made of its parts."""
    if sentence is None:
        sentence = f"{claim.figure} of {claim.named} on {claim.scenario.name}: {claim.asked}"
    elif not isinstance(sentence, str) or not sentence.strip() or not sentence.isprintable():
        raise InputError(f"{where}.claim: expected a line of text, got {shown(sentence)}")
    return replace(claim, sentence=sentence)


def odds_of_a_bad_run_doubled(at_least: float) -> float:
    """Return the share of good runs at which the odds of a bad one are twice as high: 0.9 becomes 0.818."""
    return at_least / (2.0 - at_least)


def _fraction(value: object, where: str, low: float = 0.0) -> float:
    found = number(value, where, low, 1.0, open_low=True)
    if found >= 1.0:
        raise InputError(f"{where}: expected less than 1, which no number of runs can show, got {found:g}")
    return found


def _count(value: object, where: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= 1_000_000:
        raise InputError(f"{where}: expected a whole number from 1 to a million, got {shown(value)}")
    return value
