"""Measure how the diagnosis is built and how long modules are, beside what is allowed: `python scripts/house.py`.

What is measured lies in `scripts/house_measures/`. `tests/test_house.py` holds every number to its limit.
"""

import sys

from house_measures.effects import laws_of_effects
from house_measures.limits import LIMITS, measures
from house_measures.rooms import House


def main(words: list[str]) -> int:
    """Print the rooms and every measure; with a measure's name, what it counts too."""
    from imubench.effects import EFFECTS
    from imubench.models import RIG_FILES

    house = House()
    for room, count in house.rooms().items():
        print(f"{room:20}{count:4}")
    print(f"\n{'':48}{'now':>6}{'limit':>7}{'aim':>6}")
    over = 0
    for name, (count, found) in measures(house, EFFECTS, laws_of_effects(), RIG_FILES).items():
        limit = LIMITS[name]
        note = "  over its limit" if count > limit.now else "  lower its limit" if count < limit.now else ""
        over += count > limit.now
        print(f"{name:48}{count:6}{limit.now:7}{limit.aim:6}{note}")
        if any(word in name for word in words):
            print("\n".join(f"    {line}" for line in found))
    return int(over > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
