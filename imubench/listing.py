"""What this installation knows, by kind."""

from imubench.convert import known_converters
from imubench.effects import EFFECTS
from imubench.models import RIG_FILES, RIG_SUMMARIES
from imubench.plugins import known_estimators
from imubench.reproduce import PAPERS
from imubench.scenarios import known_scenarios
from imubench.sim.profiles import PROFILES


def known() -> dict[str, dict[str, str]]:
    """Return every kind of thing, each name with one line about it."""
    return {
        "rigs": {name: RIG_SUMMARIES[name] for name in RIG_FILES},
        "scenarios": known_scenarios(),
        "estimators": {name: e.summary for name, e in known_estimators().items()},
        "profiles": {name: p.summary for name, p in PROFILES.items()},
        "formats": known_converters(),
        "effects": {name: f"{e.place}: {e.law}" for name, e in EFFECTS.items()},
        "claims": {name: p.summary for name, p in PAPERS.items()},
    }
