"""The reference of effects, computed from the code and written as docs/effects.md: what each is, and where it plays.

Three doors: `sim` injects it (`sim.injected`), a dataset draws it (`dataset`), a diagnosis' `model/` replays it
(`correction.export`). Each cell is held by tests/test_every_effect_plays.py.
"""

from dataclasses import dataclass

from imubench.correction.sensor_chain import plays
from imubench.dataset.effect_ranges import EffectRange, Shown
from imubench.effect_reference import sections
from imubench.effects import EFFECTS, VARIANTS
from imubench.models import RIG_FILES
from imubench.models.tree import rig_tree
from imubench.sim.injected import injectable

DOORS = ("sim", "dataset", "model")
OTHERWISE = {
    "gyro_noise": "noise is drawn anew: its std is the measured one",
    "accel_noise": "noise is drawn anew: its std is the measured one",
    "quantisation": "rounding follows the noise of a sample: the steps are the same, and noise and rounding are left",
    "dropouts": "which samples are lost is drawn anew: their share is the same",
    "vibration": "the phase is not among the numbers: frequency and amplitude are the same",
    "impacts": "only the times are numbers: there is a knock at each, of the law's own shape",
    "joint_play": "range and direction do not say when the limb falls: it turns as it was recovered, and by these two "
    "numbers alone between the same stops at other moments",
    "end_stop": "only the angle is a number: the limb turns round there, as stiffly as the law's prior has it",
}
"""Effects whose numbers do not say each sample, and what is the same then."""


@dataclass(frozen=True)
class Cell:
    """An effect on a rig."""

    effect: str
    rig: str
    doors: tuple[str, ...]  # of DOORS, that it goes through

    @property
    def whole(self) -> bool:
        """Whether it plays by every door."""
        return self.doors == DOORS

    @property
    def check(self) -> str:
        """How the cell is checked: every sample, a roll-out, or what its numbers say."""
        return "numbers" if self.effect in OTHERWISE else "swing" if EFFECTS[self.effect].rolled_out else "samples"


def cells() -> tuple[Cell, ...]:
    """Return every effect on every rig that has the place."""
    return tuple(cell(name, rig) for name, effect in EFFECTS.items() for rig in RIG_FILES if effect.fits(rig_tree(rig)))


def cell(name: str, rig: str) -> Cell:
    """Return an effect on a rig, with the doors that it goes through."""
    ranged = EffectRange(name, (), 1.0, {}, {})
    shown = [Shown(rig, free, rig_tree(rig).hinge is not None) for free in (False, True)]
    goes = {
        "sim": injectable(name),
        "dataset": injectable(name) and any(ranged.suits(one) for one in shown),
        "model": plays(name, rig),
    }
    return Cell(name, rig, tuple(door for door in DOORS if goes[door]))


@VARIANTS.ours_alone()
def page() -> str:
    """Return docs/effects.md."""
    found = {(c.effect, c.rig): c for c in cells()}
    lines = [
        "# Effects",
        "",
        "Every effect of the library: its law, where it acts and its parameters. Written by `python",
        "scripts/effect_table.py`; a test holds that it is what the code says. How to add one is in",
        "[add-an-effect.md](add-an-effect.md), the words are in [glossary.md](glossary.md).",
        "",
        "A parameter's plausible range is the prior that a fit has of it: centre +- one standard deviation, or a",
        "factor either way of what is positive. An array has the range in each of its numbers.",
        "",
        "## Laws and parameters",
        "",
        *sections(),
        "## Where each effect plays",
        "",
        "One law, three ways in: injected by `sim`, drawn in a dataset, replayed from a diagnosis' `model/`. In each",
        "cell an effect is concealed by the independent generator (`proof/`), its true numbers are put into a",
        "`model/`, and MuJoCo plays it (`tests/test_every_effect_plays.py`):",
        "",
        "- **samples**: measured minus played is within 1.1 of the noise, channel by channel;",
        "- **swing**: the same of a roll-out by forces alone, inside a free swing;",
        "- **numbers**: the effect's numbers do not say each sample; what is the same is said below.",
        "",
        "| effect | at | " + " | ".join(RIG_FILES) + " |",
        "|---|---|" + "---|" * len(RIG_FILES),
    ]
    for name, effect in EFFECTS.items():
        row = [_words(found.get((name, rig))) for rig in RIG_FILES]
        lines.append(f"| `{name}` | {effect.place} | " + " | ".join(row) + " |")
    lines += ["", "An empty cell: the rig has no such place. A way in that is missing is named.", ""]
    lines += [f"- `{name}`: {why}." for name, why in OTHERWISE.items()]
    return "\n".join(lines) + "\n"


def _words(cell: Cell | None) -> str:
    if cell is None:
        return ""
    return cell.check if cell.whole else f"{cell.check}; not by {', '.join(d for d in DOORS if d not in cell.doors)}"


__all__ = ["DOORS", "OTHERWISE", "Cell", "cell", "cells", "page"]
