"""The experiments that can be played; `SCENARIOS` lists them."""

from imubench.scenarios import hinge, moving_pivot, pendulum
from imubench.scenarios.olsson2020 import named
from imubench.scenarios.olsson2020.named import SequenceScenario
from imubench.scenarios.scenario import Scenario

SCENARIOS: dict[str, Scenario | SequenceScenario] = {
    s.name: s for s in (*hinge.SCENARIOS, *pendulum.SCENARIOS, *moving_pivot.SCENARIOS, *named.SCENARIOS)
}
