"""One case: a recording in format 1 with effects concealed in it, and the truth about it, kept apart."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from imubench.proof.filed import write
from imubench.proof.options import Effect, Options
from imubench.proof.played import Case, played
from imubench.proof.ranges import drawn
from imubench.proof.relative import settled
from imubench.proof.rigs import SHAPES
from imubench.proof.told import truth
from imubench.proof.unknown import NAMES as OUTSIDE

Asked = Sequence[tuple[Any, ...]]
"""Effects as (name, at) or (name, at, parameters); parameters None: drawn."""


def make_case(
    out: Path, rig: str = "hinge", effects: Asked = (), seed: int = 0, strength: str = "medium", **options: Any
) -> dict[str, Any]:
    """Write a recording into the new folder `out` and return its truth.

    effects: (name, at) or (name, at, parameters) each; without parameters they are drawn by `seed` and `strength`
    (weak, medium, strong). options: the fields of `Options`. The same arguments give the same bytes.
    """
    case = build(rig, effects, seed, strength, **options)
    write(case, out)
    return truth(case)


def build(rig: str = "hinge", effects: Asked = (), seed: int = 0, strength: str = "medium", **options: Any) -> Case:
    """Return a case in memory; see `make_case`."""
    chosen = Options(rig=rig, **options)
    if rig not in SHAPES:
        raise ValueError(f"unknown rig '{rig}'; known: {', '.join(SHAPES)}")
    if chosen.swing and (not chosen.shape.jointed or (chosen.shape.hinge and not chosen.clamped)):
        raise ValueError("a swing needs a pendulum, or a hinge with base='fixed'")
    found: list[Effect] = []
    for name, at, *rest in effects:
        given = rest[0] if rest and rest[0] is not None else None
        parameters = given if given is not None else drawn(name, at, chosen, seed, strength)
        found.append(Effect(name, at, parameters, name not in OUTSIDE))
    return played(chosen, settled(chosen, found, seed), seed)
