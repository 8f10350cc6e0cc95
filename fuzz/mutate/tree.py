"""Nested tables, lists and values, as TOML and JSON have them, changed in a few places."""

from copy import deepcopy
from random import Random
from typing import Any

from fuzz.mutate import nasty

MILD = 0.4  # of the changes leave a tree that its reader may well accept: what follows reading is tried too
FACTORS = (-1.0, 0.0, 0.1, 0.5, 2.0, 10.0, 1e-6, 1e6)
MOST = 10_000_000  # characters that one change adds: copies of copies would fill the memory
Place = tuple[Any, Any]
"""A table or list and the key or index in it."""


def changed(tree: Any, rng: Random, raw: tuple[str, ...]) -> Any:
    """Return a copy of a tree with one to four changes; `raw` are tokens of its format that no writer would write."""
    out = {"": deepcopy(tree)}
    if rng.random() < MILD:
        _change_mildly(out, _place(out, rng), rng)
        return out.get("", {})
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
        often = min(rng.choice((1, 2, 1_000)), max(1, MOST // _size(value)))
        holder.extend(deepcopy(value) for _ in range(often))
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


def _change_mildly(top: dict[str, Any], place: Place, rng: Random) -> None:
    """Put a value in place that could as well stand there."""
    holder, key = place
    value = holder[key]
    if isinstance(value, bool):
        holder[key] = not value
    elif isinstance(value, int | float):
        new = value * rng.choice(FACTORS) if rng.random() < 0.7 else _near(value, rng)
        holder[key] = int(new) if isinstance(value, int) and isinstance(new, float) and rng.random() < 0.5 else new
    elif isinstance(value, str):
        others = [found for found in _leaves(top) if isinstance(found, str)]
        holder[key] = rng.choice(others) if rng.random() < 0.6 else rng.choice(nasty.TEXTS)
    elif isinstance(value, list):
        shorter, twice = value[: rng.randint(0, len(value))], value + value[:1]
        holder[key] = rng.choice((shorter, twice, value[::-1], [], value[1:]))
    elif isinstance(value, dict) and value:
        value.pop(rng.choice(list(value)))


def _leaves(value: Any) -> list[Any]:
    if isinstance(value, dict | list):
        return [leaf for v in (value.values() if isinstance(value, dict) else value) for leaf in _leaves(v)]
    return [value]


def _size(value: Any) -> int:
    """Return about how many characters a tree is as text."""
    if isinstance(value, dict):
        return 2 + sum(len(str(key)) + _size(v) for key, v in value.items())
    return 2 + sum(map(_size, value)) if isinstance(value, list) else 2 + len(value) if isinstance(value, str) else 8


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
