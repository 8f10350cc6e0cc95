"""What docs/effects.md says of each effect: its phrase, law, place and parameters, taken from the code."""

from collections.abc import Iterator

import numpy as np

from imubench.effects import EFFECTS, VARIANTS
from imubench.effects.effect import Effect, Parameter
from imubench.explain import PLACES, always_alike, of_effect
from imubench.models import RIG_FILES
from imubench.models.tree import rig_tree

NEEDED = {
    "free_swings": "a declared free swing of a declared body",
    "encoders": "an encoder",
    "imus": "an IMU",
}
"""What an effect asks of a recording, in words."""
HEAD = ("parameter", "shape", "unit", "plausible range")


def sections() -> Iterator[str]:
    """Yield the lines of one section for each effect, in the order of `EFFECTS`."""
    for name, effect in EFFECTS.items():
        yield from section(name, effect)


def section(name: str, effect: Effect) -> Iterator[str]:
    """Yield the lines of the section of one effect.

    Args:
        name: of the effect, the section's heading.
        effect: with the first of its settings.
    """
    needs = "".join(f", needs {NEEDED[need]}" for need in effect.needs)
    yield from (f"### {name}", "", of_effect(name, effect).text, "")
    yield f"- law: `{effect.law}`"
    fitting = [rig for rig in RIG_FILES if effect.fits(rig_tree(rig))]
    yield f"- acts {PLACES[effect.place]}; rigs: {', '.join(fitting)}{needs}"
    if variants := [v.variant for v in VARIANTS if v.name == name and v.variant]:
        yield f"- variants that a diagnosis also tries: {', '.join(variants)}"
    if effect.states:
        kind = "follow the law" if effect.lawful else "smooth splines, without a law"
        yield f"- dynamic states: {', '.join(f'{s.name} ({s.width})' for s in effect.states)}; {kind}"
    if same := always_alike(effect):
        yield f"- no motion tells it from: {same}"
    rows = [*(parameter_row(p) for p in effect.parameters), *(found_rows(effect))]
    if rows:
        yield from ("", *(f"| {' | '.join(cells)} |" for cells in (HEAD, ("---",) * len(HEAD), *rows)))
    yield ""


def parameter_row(p: Parameter) -> tuple[str, str, str, str]:
    """Return a fitted parameter's cells of `HEAD`."""
    name = f"`{p.name}`" if p.reported else f"`{p.name}`, not reported"
    return name, shape_of(p.shape), unit_of(p.unit), prior_of(p)


def found_rows(effect: Effect) -> Iterator[tuple[str, str, str, str]]:
    """Yield the cells of parameters that are read off the samples or the states."""
    for f in effect.found:
        if f.name not in {p.name for p in effect.parameters}:
            yield f"`{f.name}`", shape_of(f.shape), unit_of(f.unit), "read off the samples or the states"


def shape_of(shape: tuple[int | None, ...]) -> str:
    """Return a shape in words; None in it is any number."""
    return " x ".join("n" if size is None else str(size) for size in shape) or "1"


def unit_of(unit: str) -> str:
    """Return a unit, a dash where there is none."""
    return "-" if unit == "1" else unit


def prior_of(p: Parameter) -> str:
    """Return the prior that a fit has of a parameter: its centre and one standard deviation."""
    start = np.atleast_1d(np.asarray(p.start, dtype=float))
    centre = f"{start[0]:g}" if np.all(start == start[0]) else f"({', '.join(f'{x:g}' for x in start)})"
    if p.log:
        return f"{centre}, within a factor of {np.exp(p.std):.2g}"
    return f"{centre} +- {p.std:g}" + (", not negative" if p.sided else "")


__all__ = ["parameter_row", "prior_of", "section", "sections", "shape_of"]
