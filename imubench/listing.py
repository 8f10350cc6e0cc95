"""What this installation knows, by kind."""

from imubench.convert import known_converters
from imubench.diagnosis.rules import RULES
from imubench.effects import EFFECTS
from imubench.models import RIG_FILES
from imubench.plugins import known_estimators
from imubench.reproduce import PAPERS
from imubench.scenarios import known_scenarios
from imubench.sim.profiles import PROFILES

RIG_SUMMARIES = {
    "hinge": "two segments on a hinge that a screw can lock, free or fixed base, an IMU on each",
    "pendulum": "a limb on a ball joint, an IMU on it",
    "free": "one body that moves at will, an IMU on it",
}


def known() -> dict[str, dict[str, str]]:
    """Return every kind of thing, each name with one line about it."""
    return {
        "rigs": {name: RIG_SUMMARIES[name] for name in RIG_FILES},
        "scenarios": known_scenarios(),
        "estimators": {name: e.summary for name, e in known_estimators().items()},
        "profiles": {name: p.summary for name, p in PROFILES.items()},
        "formats": known_converters(),
        "effects": {name: f"{e.place}: {e.law}" for name, e in EFFECTS.items()},
        "rules": dict(RULES),
        "claims": {name: p.summary for name, p in PAPERS.items()},
    }
