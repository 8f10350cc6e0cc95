"""The experiments that can be played; `SCENARIOS` lists them."""

from imubench.scenarios import hinge, moving_pivot, pendulum
from imubench.scenarios.scenario import Scenario

SCENARIOS: dict[str, Scenario] = {s.name: s for s in (*hinge.SCENARIOS, *pendulum.SCENARIOS, *moving_pivot.SCENARIOS)}
