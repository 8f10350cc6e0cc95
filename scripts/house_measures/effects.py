"""Where the diagnosis goes by one particular effect: by its name, or by its law."""

import ast
from collections.abc import Collection, Mapping
from importlib import import_module

from .rooms import House
from .sources import ROOT

WORDS_FOR_PEOPLE = ("report",)  # rooms in which an effect has its name in words


def effects_named(house: House, effects: Mapping[str, object]) -> list[str]:
    """Return where an effect is named in quotes, with a place or without, but in rooms that speak to people."""
    return [
        f"{m.name}:{node.lineno}: {node.value}"
        for m in house.modules.values()
        if m.room not in WORDS_FOR_PEOPLE
        for node in ast.walk(m.tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        if node.value.partition("@")[0] in effects
    ]


def laws_used(house: House, laws: Collection[str]) -> list[str]:
    """Return where one particular law is used: its class or an object of it, imported from a file of `effects/`.

    Where it is asked for its class, made anew, or written into a signature; `laws` are the names of all of them.
    """
    found = []
    for m in house.modules.values():
        own = {
            alias.asname or alias.name: alias.name
            for node in ast.walk(m.tree)
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("imubench.effects.")
            for alias in node.names
            if alias.name in laws
        }
        uses = (n for n in ast.walk(m.tree) if isinstance(n, ast.Name) and n.id in own)
        found += [f"{m.name}:{n.lineno}: {own[n.id]}" for n in uses]
    return found


def laws_of_effects() -> set[str]:
    """Return the names in the files of `effects/` of every class of an effect, and of every object of one."""
    import imubench.effects
    from imubench.effects.effect import Effect

    files = (f"{imubench.effects.__name__}.{p.stem}" for p in (ROOT / "effects").glob("[a-z]*.py"))
    return {
        name
        for file in files
        for name, x in vars(import_module(file)).items()
        if isinstance(x, Effect) or (isinstance(x, type) and issubclass(x, Effect) and x is not Effect)
    }
