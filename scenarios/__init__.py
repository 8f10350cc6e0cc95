"""The experiments that can be played; `SCENARIOS` lists ours, and installed packages may offer more, and rigs."""

from imubench.entry_points import SCENARIOS as POINTS
from imubench.entry_points import from_package, offered, origin
from imubench.errors import unknown
from imubench.scenarios import hinge, moving_pivot, pendulum
from imubench.scenarios.of_rigs import by_hand, known_by_hand, rig_of
from imubench.scenarios.olsson2020 import named
from imubench.scenarios.olsson2020.named import SequenceScenario
from imubench.scenarios.scenario import Scenario

SCENARIOS: dict[str, Scenario | SequenceScenario] = {
    s.name: s for s in (*hinge.SCENARIOS, *pendulum.SCENARIOS, *moving_pivot.SCENARIOS, *named.SCENARIOS)
}


def find_scenario(name: str) -> Scenario | SequenceScenario:
    """Return the scenario of that name, ours or an installed package's; `InputError` lists those that are known."""
    if name in SCENARIOS:
        return SCENARIOS[name]
    found = from_package(POINTS, name, "scenario", Scenario)
    if found is None and (rig := rig_of(name)) is not None:
        return by_hand(rig)
    if not isinstance(found, Scenario):
        raise unknown("scenario", name, known_scenarios())
    return found


def known_scenarios() -> dict[str, str]:
    """Return the scenarios by name, each with one line about it; no package is imported for that."""
    outside = {name: origin(points) for name, points in offered(POINTS).items()}
    ours = {name: s.summary for name, s in SCENARIOS.items()}
    return {**ours, **known_by_hand(), **outside, **ours}
