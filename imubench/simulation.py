"""A scenario's recording and its truth, and what a run may change of it: the IMU, the duration, left-out physics."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from imubench.entry_points import blamed
from imubench.errors import InputError
from imubench.models.tree import rig_tree
from imubench.recording import Recording, positive
from imubench.truth import Truth

if TYPE_CHECKING:  # what plays is imported where something is played
    from imubench.dataset.effect_ranges import EffectRange

EFFECTS = 1  # beside a seed: what draws the numbers of effects
NEED_MORE = ("end_stop",)  # effects whose numbers say nothing without where the limb hangs, which a dataset knows


@dataclass(frozen=True)
class Changes:
    """What a run changes of a scenario."""

    imu: str | None = None  # another IMU's profile
    seconds: float | None = None  # s
    effects: "tuple[EffectRange, ...]" = ()  # left-out physics, drawn with the seed

    def __bool__(self) -> bool:
        """Whether there is anything."""
        return self != Changes()


AS_IT_IS = Changes()


def simulate(scenario: str, seed: int = 0, changes: Changes = AS_IT_IS) -> tuple[Recording, Truth]:
    """Return the recording of a scenario, and its truth; the same seed gives the same numbers.

    Raises:
        InputError: an unknown scenario or IMU; a duration that its motion cannot have; effects as in `effects_of`.
    """
    from imubench.scenarios import SCENARIOS, find_scenario
    from imubench.sim.profiles import profile

    plan = find_scenario(scenario)
    imu = None if changes.imu is None else profile(changes.imu)
    effects = effects_of(scenario, seed, changes)
    if scenario in SCENARIOS:
        return plan.record(seed, imu, changes.seconds, effects)
    with blamed(f"scenario '{scenario}'"):
        return plan.record(seed, imu, changes.seconds, effects)


def effects_of(scenario: str, seed: int, changes: Changes) -> list[dict[str, Any]]:
    """Return the effects that a run of a scenario has, each with its place and its numbers.

    Raises:
        InputError: one would not show in the scenario, or comes twice at one place.
    """
    from imubench.dataset.effect_ranges import Shown, check_once
    from imubench.scenarios import find_scenario

    plan = find_scenario(scenario)
    seconds = plan.seconds if changes.seconds is None else changes.seconds
    positive(seconds, "duration")
    check_once(changes.effects)
    shown = Shown(plan.rig, plan.swings, encoder=False)
    for effect in changes.effects:
        if not effect.suits(shown) or effect.name in NEED_MORE:
            raise InputError(f"{scenario}: expected an effect that can be played in it, got {effect.name}")
    places = (*rig_tree(plan.rig).imus, "joint", "body", "world")
    own = zip(changes.effects, np.random.default_rng([seed, EFFECTS]).spawn(len(changes.effects)), strict=True)
    return [found for effect, rng in own for found in effect.draw(rng, places, seconds)]
