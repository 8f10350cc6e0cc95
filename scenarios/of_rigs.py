"""A rig that an installed package offers, moved by a hand: a scenario of each, `RIG-hand`."""

from collections.abc import Sequence

import numpy as np

from imubench.models import RIG_FILES, is_rig, known_rigs
from imubench.models.tree import BALL, HINGE, rig_tree
from imubench.scenarios.hinge import hand_motion
from imubench.scenarios.scenario import Experiment, Scenario, prescribed
from imubench.sim.injected import Injected
from imubench.sim.rigs import standard_rig

BY_HAND = "-hand"
ESTIMATORS = {HINGE: "olsson2020", BALL: "arve-d"}
"""By kind of rig: the estimator that `run` takes by default, as on our own rigs."""


def rig_of(scenario: str) -> str | None:
    """Return the rig of a package that a scenario moves by hand; None where that is not what it is."""
    rig = scenario.removesuffix(BY_HAND)
    return rig if rig != scenario and rig not in RIG_FILES and is_rig(rig) else None


def by_hand(rig: str) -> Scenario:
    """Return a package's rig as its file has it, moved by a hand; `InputError` where there is none that can be."""

    def moved(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
        return prescribed(standard_rig(rig), hand_motion(rng, seconds), seconds, rng, effects)

    estimator = ESTIMATORS.get(rig_tree(rig).kind)
    return Scenario(f"{rig}{BY_HAND}", f"the rig {rig}, moved by a hand", estimator, "xsens_mtw", moved, rig)


def known_by_hand() -> dict[str, str]:
    """Return these scenarios by name, each with one line about it; no package is imported for that."""
    outside = {rig: line for rig, line in known_rigs().items() if rig not in RIG_FILES}
    return {f"{rig}{BY_HAND}": f"the rig {rig} {line}, moved by a hand" for rig, line in outside.items()}


__all__ = ["by_hand", "known_by_hand", "rig_of"]
