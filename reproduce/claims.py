"""Claims of a paper as data, and what a run says about them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Literal

from imubench.errors import InputError, unknown
from imubench.inputs.files import read_bytes
from imubench.inputs.toml import parse_toml

Kind = Literal["at most", "at least", "about"]
Verdict = Literal["holds", "fails", "differs"]

KEYS = {
    "claim": str,
    "source": str,
    "published": float,
    "unit": str,
    "kind": str,
    "limit": float,
    "basis": str,
    "measure": str,
    "promise": bool,
}
OPTIONAL: Mapping[str, type] = {"guard": float, "known": str}
KINDS = ("at most", "at least", "about")
SIGNS = {"at most": "<=", "at least": ">="}


@dataclass(frozen=True)
class Claim:
    """A sentence of a paper with a number in it, and what would count as the same number here.

    A promise is something the method guarantees its user: it holds or fails. Anything else is a figure that
    the authors saw: it holds or differs.
    """

    name: str
    claim: str  # one sentence
    source: str  # where it stands
    published: float  # in `unit`
    unit: str
    kind: Kind
    limit: float  # in `unit`: the bound, or for "about" the tolerance around `published`
    basis: str  # where the limit comes from
    measure: str  # name of the function that measures it
    promise: bool
    guard: float | None = None  # in `unit`: beyond it the code has become worse than it was, whatever the paper says
    known: str = ""  # why the claim is known to fail; without it a failure is news

    @property
    def bound(self) -> str:
        """The bound as text: `<= 2.16 deg`, `90 +- 15 deg`."""
        if self.kind == "about":
            return f"{self.published:g} +- {self.limit:g} {self.unit}".strip()
        return f"{SIGNS[self.kind]} {self.limit:g} {self.unit}".strip()

    def meets(self, value: float) -> bool:
        """Tell whether a value in `unit` is within the bound; NaN is not."""
        slack = 1e-9 * max(1.0, abs(self.limit), abs(self.published))  # 0.1 + 0.2 is at most 0.3
        if self.kind == "about":
            return abs(value - self.published) <= self.limit + slack
        return value <= self.limit + slack if self.kind == "at most" else value >= self.limit - slack

    def keeps(self, value: float) -> bool:
        """Tell whether a value in `unit` is on the right side of the guard, where there is one; NaN is not."""
        if self.guard is None:
            return True
        return value >= self.guard if self.kind == "at least" else value <= self.guard


@dataclass(frozen=True)
class Measured:
    """What a run gave for a claim, and the words that go with it."""

    value: float  # in the claim's unit; NaN where the run gave none
    why: str  # numbers of the run that explain the value


@dataclass(frozen=True)
class Judged:
    """A claim, its measurement and its verdict."""

    claim: Claim
    measured: Measured
    verdict: Verdict

    @property
    def worse(self) -> bool:
        """Whether the code has become worse than its guard."""
        return not self.claim.keeps(self.measured.value)

    @property
    def news(self) -> str:
        """What a run should stop for: a failure that is not known, or a broken guard; empty where there is none."""
        if self.worse:
            return f"{self.measured.value:.3g} {self.claim.unit} is beyond the guard of {self.claim.guard:g}"
        if self.verdict == "fails" and not self.claim.known:
            return f"{self.measured.value:.3g} {self.claim.unit} instead of {self.claim.bound}"
        return ""

    def as_dict(self) -> dict[str, Any]:
        """Return the entry of claims.json."""
        value = self.measured.value
        return {
            "name": self.claim.name,
            "claim": self.claim.claim,
            "source": self.claim.source,
            "published": self.claim.published,
            "measured": value if math.isfinite(value) else None,
            "unit": self.claim.unit,
            "bound": self.claim.bound,
            "basis": self.claim.basis,
            "test": self.claim.measure,
            "verdict": self.verdict,
            "why": self.measured.why,
            "guard": self.claim.guard,
            "known": self.claim.known or None,
            "news": self.news or None,
        }


def judge(claim: Claim, measured: Measured) -> Judged:
    """Return the verdict: within its bound a claim holds; outside, a promise fails and a figure differs."""
    if claim.meets(measured.value):
        return Judged(claim, measured, "holds")
    return Judged(claim, measured, "fails" if claim.promise else "differs")


def load_claims(file: Traversable | Path, measures: Mapping[str, object]) -> tuple[Claim, ...]:
    """Return the claims of a TOML file, one table each, keyed by name.

    Raises `InputError` for a missing or unknown key, a wrong type, or a measure that is not in `measures`.
    """
    content = read_bytes(file) if isinstance(file, Path) else file.read_bytes()
    tables = parse_toml(content, file.name)
    return tuple(_claim(name, table, f"{file.name}: {name}", measures) for name, table in tables.items())


def _claim(name: str, table: object, where: str, measures: Mapping[str, object]) -> Claim:
    if not isinstance(table, dict):
        raise InputError(f"{where}: expected a table, got {table!r}")
    for key in table:
        if key not in KEYS and key not in OPTIONAL:
            raise unknown(f"key in {where}", key, [*KEYS, *OPTIONAL])
    fields: dict[str, Any] = {"promise": False} | table
    for key, kind in KEYS.items():
        if key not in fields:
            raise InputError(f"{where}: expected the key '{key}', got {', '.join(table) or 'none'}")
        fields[key] = _typed(fields[key], kind, f"{where}.{key}")
    for key in OPTIONAL.keys() & fields.keys():
        fields[key] = _typed(fields[key], OPTIONAL[key], f"{where}.{key}")
    if fields["kind"] not in KINDS:
        raise unknown(f"kind in {where}", fields["kind"], KINDS)
    if fields["kind"] == "about" and fields["promise"]:
        raise InputError(f"{where}: expected a promise with a bound on one side, got one of kind 'about'")
    if "known" in fields and not fields["promise"]:
        raise InputError(f"{where}.known: expected a promise, which can fail, got a figure, which can only differ")
    if fields["measure"] not in measures:
        raise unknown(f"measure in {where}", fields["measure"], measures)
    return Claim(name=name, **fields)


def _typed(value: object, kind: type, where: str) -> object:
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
        return float(value)
    if kind is not float and type(value) is kind and value != "":
        return value
    names = {float: "a finite number", str: "a text", bool: "true or false"}
    raise InputError(f"{where}: expected {names[kind]}, got {value!r}")
