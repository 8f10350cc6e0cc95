"""Every measure, beside what it may be at most."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from .constants import ambiguous, numeric, settings
from .docstrings import past_figures
from .effects import effects_named, laws_used
from .imports import chain, upward
from .lengths import too_long
from .rigs import parts_named, rig_branches
from .rooms import House


@dataclass(frozen=True)
class Limit:
    """What a measure may be at most today, and what it is to become."""

    now: int
    aim: int


LIMITS: Mapping[str, Limit] = {
    "modules in the largest room": Limit(15, 15),
    "upward imports": Limit(0, 0),
    "modules over 400 lines": Limit(0, 0),
    "longest import chain": Limit(14, 14),
    "numeric constants": Limit(87, 87),
    "numbers in the config": Limit(397, 150),
    "constants of one name with different values": Limit(0, 0),
    "effects named outside of effects/": Limit(0, 0),
    "laws of effects used outside of effects/": Limit(0, 0),
    "docstrings with a past run's figure": Limit(0, 0),
    "branches on a rig's name": Limit(0, 0),
    "segments and IMUs by their name": Limit(0, 0),
}
"""Lower a limit in the change that lowers its measure. Where `now` is the aim, it is no longer a matter of time."""


def measures(
    house: House, effects: Mapping[str, object], laws: Collection[str], rigs: Collection[str]
) -> dict[str, tuple[int, list[str]]]:
    """Return each measure's number and what it counts.

    Args:
        house: of the checkout that is measured.
        effects: by name.
        laws: as `laws_of_effects` names them.
        rigs: their names.
    """
    rooms = house.rooms()
    longest = chain(house)
    counted: dict[str, Callable[[], list[str]]] = {
        "upward imports": lambda: upward(house),
        "modules over 400 lines": lambda: too_long(house.root),
        "numeric constants": lambda: numeric(house),
        "numbers in the config": lambda: settings(house),
        "constants of one name with different values": lambda: ambiguous(house),
        "effects named outside of effects/": lambda: effects_named(house, effects),
        "laws of effects used outside of effects/": lambda: laws_used(house, laws),
        "docstrings with a past run's figure": lambda: past_figures(house),
        "branches on a rig's name": lambda: rig_branches(house.root, rigs),
        "segments and IMUs by their name": lambda: parts_named(house),
    }
    out = {
        "modules in the largest room": (max(rooms.values()), [f"{room} {n}" for room, n in rooms.items()]),
        "longest import chain": (len(longest), longest),
    }
    out |= {name: (len(found), found) for name, found in ((name, count()) for name, count in counted.items())}
    return {name: out[name] for name in LIMITS}
