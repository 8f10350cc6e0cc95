"""Nested tables, lists and values, as TOML and JSON have them, changed in a few places."""

from copy import deepcopy
from random import Random
from typing import Any

from fuzz.mutate import nasty

Place = tuple[Any, Any]
"""A table or list and the key or index in it."""


def changed(tree: Any, rng: Random, raw: tuple[str, ...]) -> Any:
    """Return a copy of a tree with one to four changes; `raw` are tokens of its format that no writer would write."""
    out = {"": deepcopy(tree)}
    for _ in range(1 + min(int(rng.expovariate(1.0)), 3)):
        _change(out, _place(out, rng), rng, raw)
    return out.get("", {})


def _place(top: dict[str, Any], rng: Random) -> Place:
    """Return a place on the way down: the deeper a tree, the more of its places are deep."""
    holder, key = top, ""
    while True:
        found = holder[key]
        if not isinstance(found, dict | list) or not found or rng.random() < 0.12:
            return holder, key
        holder, key = found, rng.choice(list(found) if isinstance(found, dict) else range(len(found)))


def _change(top: dict[str, Any], place: Place, rng: Random, raw: tuple[str, ...]) -> None:
    holder, key = place
    value = holder[key]
    kind = rng.randrange(12)
    if kind < 4:
        holder[key] = _value(rng, raw)
    elif kind == 4 and isinstance(value, int | float) and not isinstance(value, bool):
        holder[key] = _near(value, rng)
    elif kind == 5 and holder is not top:
        del holder[key]
    elif kind == 6 and isinstance(holder, dict) and holder is not top:
        name = nasty.text(rng) if rng.random() < 0.5 else rng.choice(list(holder))
        holder[name] = holder.pop(key)
    elif kind == 7 and isinstance(holder, list):
        holder.extend(deepcopy(value) for _ in range(rng.choice((1, 2, 1_000))))
    elif kind == 8:
        holder[key] = rng.choice(([value], {"value": value}, [value, value], [[value]], {nasty.text(rng): value}))
    elif kind == 9 and isinstance(value, dict | list) and value:
        holder[key] = rng.choice(list(value.values()) if isinstance(value, dict) else value)
    elif kind == 10:
        other, name = _place(top, rng)
        holder[key] = deepcopy(other[name])
    elif isinstance(value, dict):
        value[nasty.text(rng)] = _value(rng, raw)
    elif isinstance(value, list):
        value.insert(rng.randint(0, len(value)), _value(rng, raw))
    else:
        holder[key] = str(value) if rng.random() < 0.5 else _value(rng, raw)


def _value(rng: Random, raw: tuple[str, ...]) -> Any:
    kind = rng.random()
    if kind < 0.3:
        return nasty.number(rng)
    if kind < 0.55:
        return nasty.text(rng)
    return nasty.container(rng) if kind < 0.8 else nasty.Raw(rng.choice(raw))


def _near(value: float, rng: Random) -> Any:
    try:
        return rng.choice((-value, value + 1, float(value), str(value), value * 1_000, value / 1_000, int(value)))
    except (OverflowError, ValueError):  # infinity, or more than a float holds
        return -value
