"""What this installation knows, by kind. What a kind needs is imported when it is asked for, as a shell may."""

from collections.abc import Callable, Mapping


def _rigs() -> dict[str, str]:
    from imubench.models import known_rigs

    return known_rigs()


def _scenarios() -> dict[str, str]:
    from imubench.scenarios import known_scenarios

    return known_scenarios()


def _estimators() -> dict[str, str]:
    from imubench.plugins import known_estimators

    return {name: e.summary for name, e in known_estimators().items()}


def _profiles() -> dict[str, str]:
    from imubench.sim.profiles import PROFILES

    return {name: p.summary for name, p in PROFILES.items()}


def _formats() -> dict[str, str]:
    from imubench.convert import known_converters

    return known_converters()


def _effects() -> dict[str, str]:
    from imubench.effects import EFFECTS

    return {name: f"{e.place}: {e.law}" for name, e in EFFECTS.items()}


def _rules() -> dict[str, str]:
    from imubench.diagnosis.rules import RULES

    return dict(RULES)


def _claims() -> dict[str, str]:
    from imubench.reproduce import PAPERS

    return {name: p.summary for name, p in PAPERS.items()}


KINDS: Mapping[str, Callable[[], dict[str, str]]] = {
    "rigs": _rigs,
    "scenarios": _scenarios,
    "estimators": _estimators,
    "profiles": _profiles,
    "formats": _formats,
    "effects": _effects,
    "rules": _rules,
    "claims": _claims,
}
"""By kind a function that returns each name with one line about it."""


def known() -> dict[str, dict[str, str]]:
    """Return every kind of thing, each name with one line about it."""
    return {kind: names() for kind, names in KINDS.items()}
