"""The figures that a claim may be about: those of `imubench.score`, by name, with their units."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from imubench.dataset.ranges import is_number
from imubench.errors import InputError, shown, unknown
from imubench.estimate import Quantity
from imubench.figures import scored
from imubench.score import BEST_PAIRING, Score, maxae, rmsae
from imubench.units import UNITS

KNOWN = scored()
"""Every figure that an estimate of our rigs can have."""
BOUND = re.compile(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*([A-Za-z]+)\s*")


@dataclass(frozen=True)
class Bound:
    """A limit as its author wrote it: `2 deg`."""

    value: float  # in `unit`
    unit: str
    si: float  # in rad or m

    def __str__(self) -> str:
        """The limit with its unit."""
        return f"{self.value:g} {self.unit}"

    def shown(self, si: float) -> str:
        """Return a value in rad or m in the limit's unit, three digits."""
        return f"{self.in_unit(si):.3g} {self.unit}"

    def in_unit(self, si: float) -> float:
        """Return a value in rad or m in the limit's unit."""
        return si * self.value / self.si


def parse_bound(text: object, figure: str, where: str) -> Bound:
    """Return the bound in a text such as `2 deg`; `InputError` for another form, or a unit that the figure has not."""
    units = UNITS[KNOWN[figure].unit]
    found = BOUND.fullmatch(text) if isinstance(text, str) else None
    number = _number(found[1]) if found is not None else 0.0
    if found is None or not is_number(number) or number <= 0:
        example = "2 deg" if "deg" in units else "5 mm"
        raise InputError(f"{where}: expected a number above 0 and its unit, as in '{example}', got {shown(text)}")
    if found[2] not in units:
        raise unknown(f"unit of {figure} in {where}", found[2], units)
    return Bound(number, found[2], number * units[found[2]])


def known_figures(quantity: Quantity | None) -> list[str]:
    """Return the figures of a quantity, or all where it is not known yet."""
    return [name for name, one in KNOWN.items() if quantity in (None, one.quantity)]


def check_figure(figure: object, quantity: Quantity | None, estimator: str, where: str) -> str:
    """Return a figure's name; `InputError` names those that the estimator's answers can have."""
    known = known_figures(quantity)
    if not isinstance(figure, str) or figure not in known:
        raise unknown(f"figure of {estimator} in {where}", figure, known)
    return figure


def figures_of(score: Score) -> dict[str, float]:
    """Return a score's figures; of axes whose sign pairing is known also those of the better pairing.

    A figure of the better pairing can always be claimed: it asks less. One of paired axes can not where the pairing is
    unknown, see `why_missing`.
    """
    found = dict(score.figures)
    if score.quantity == "joint_axis" and "rmsae" in found:
        lines = {name: min(d, math.pi - d) for name, d in found.items() if name.startswith("deviation_")}
        ends = {"rmsae": rmsae(list(lines.values())), "maxae": maxae(list(lines.values()))}
        found |= {f"{BEST_PAIRING}{name}": value for name, value in (lines | ends).items()}
    return found


def why_missing(figure: str, figures: Mapping[str, float], estimator: str) -> str:
    """Return why an estimate has no such figure; `InputError` where its estimator's estimates never have it."""
    if f"{BEST_PAIRING}{figure}" in figures:
        return f"the sign pairing is unknown, which leaves {BEST_PAIRING}{figure}"
    raise unknown(f"figure of {estimator}", figure, figures)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:  # 1.2.3
        return 0.0
