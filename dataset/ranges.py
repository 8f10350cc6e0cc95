"""Numbers that a spec leaves open: fixed, uniform, log-uniform or normal."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError, unknown

FORMS = "a number, [low, high], { low, high, scale = 'log' } or { std, mean }"


@dataclass(frozen=True)
class Range:
    """Where a number is drawn from."""

    kind: Literal["uniform", "log", "normal"]
    a: float  # low; mean
    b: float  # high; std

    def draw(self, rng: np.random.Generator, shape: tuple[int, ...] = ()) -> Array:
        """Return an array of draws, each on its own; a range of one value draws nothing from `rng`."""
        if self.kind == "normal":
            return np.asarray(self.a + self.b * rng.standard_normal(shape))
        if self.a == self.b:
            return np.full(shape, self.a)
        if self.kind == "log":
            return np.asarray(np.exp(rng.uniform(np.log(self.a), np.log(self.b), shape)))
        return np.asarray(rng.uniform(self.a, self.b, shape))

    def one(self, rng: np.random.Generator) -> float:
        """Return one draw."""
        return float(self.draw(rng))

    @property
    def low(self) -> float:
        """The smallest number that may come."""
        return -np.inf if self.kind == "normal" and self.b else self.a

    @property
    def high(self) -> float:
        """The largest number that may come."""
        return np.inf if self.kind == "normal" and self.b else max(self.a, self.b if self.kind != "normal" else self.a)


def parse_range(value: object, where: str, low: float = -np.inf, high: float = np.inf, open_low: bool = False) -> Range:
    """Return the range that a spec's value stands for.

    Raises `InputError` for another form, an empty range, or numbers beyond `low` and `high`; `open_low` excludes `low`.
    """
    found = _parsed(value, where)
    below = found.low <= low if open_low else found.low < low
    if below or found.high > high:
        limits = f"{'>' if open_low else '>='} {low:g}" if np.isfinite(low) else ""
        limits += f"{' and ' if limits else ''}<= {high:g}" if np.isfinite(high) else ""
        raise InputError(f"{where}: expected numbers {limits}, got {value!r}")
    return found


def _parsed(value: object, where: str) -> Range:
    if is_number(value):
        return Range("uniform", float(value), float(value))  # type: ignore[arg-type]
    if isinstance(value, list) and len(value) == 2 and all(is_number(x) for x in value):
        return _ordered("uniform", value[0], value[1], where)
    if isinstance(value, dict):
        check_keys(value, ("low", "high", "scale") if "low" in value or "high" in value else ("std", "mean"), where)
        if is_number(value.get("low")) and is_number(value.get("high")):
            if value.get("scale", "uniform") not in ("uniform", "log"):
                raise unknown(f"scale in {where}", value["scale"], ("uniform", "log"))
            return _ordered(value.get("scale", "uniform"), value["low"], value["high"], where)
        if is_number(value.get("std")) and is_number(value.get("mean", 0.0)) and value["std"] >= 0:
            return Range("normal", float(value.get("mean", 0.0)), float(value["std"]))
    raise InputError(f"{where}: expected {FORMS}, got {value!r}")


def _ordered(kind: Any, low: float, high: float, where: str) -> Range:
    if not low <= high:
        raise InputError(f"{where}: expected a range from low to high, got {low:g} to {high:g}")
    if kind == "log" and low <= 0:
        raise InputError(f"{where}: expected a range above 0 for scale = 'log', got {low:g} to {high:g}")
    return Range(kind, float(low), float(high))


def is_number(value: object) -> bool:
    """Return whether a TOML value is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))


def check_keys(table: Mapping[str, Any], known: Sequence[str], where: str) -> None:
    """Raise `InputError` for a key that is not known."""
    for key in table:
        if key not in known:
            raise unknown(f"key in {where}", key, known)


def number(value: object, where: str, low: float = 0.0, high: float = np.inf, open_low: bool = False) -> float:
    """Return a plain number within its limits; `InputError` otherwise."""
    if not is_number(value):
        raise InputError(f"{where}: expected a number, got {value!r}")
    return parse_range(value, where, low, high, open_low).a


def weight(table: Mapping[str, Any], where: str) -> float:
    """Return how often an entry is drawn beside the others, above 0; 1 if its table does not say."""
    return number(table.get("weight", 1.0), f"{where}.weight", open_low=True)


def chosen(value: object, where: str, known: Sequence[str]) -> str:
    """Return a text that is one of those known; `InputError` names them."""
    if value not in known:
        raise unknown(where, value, known)
    return str(value)


@contextmanager
def located(where: str) -> Iterator[None]:
    """Say where an `InputError` that leaves this context comes from."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
