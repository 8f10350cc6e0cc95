"""The hinge axis by every estimator on the four sequences of Olsson 2020: python -m benchmarks.baselines [SEEDS].

Prints the table of docs/plug-and-play.md: the larger error of both axes in deg, median and worst of the seeds.
"""

import sys

import numpy as np

from benchmarks.guard_table import sequences
from imubench.estimators import find
from imubench.score import axis_deviation

NAMES = "olsson2020", "olsson2020-plug-and-play", "olsson2020-guarded", "seel2012", "accel-svd", "qmt"
SEQUENCES = "sequence1", "sequence2", "sequence3", "sequence4"


def errors(seeds: int) -> dict[tuple[str, str], list[float]]:
    """Return the errors in rad by estimator and sequence; those that are called not identifiable count as well."""
    found: dict[tuple[str, str], list[float]] = {}
    for sequence in SEQUENCES:
        for one in sequences(range(800, 800 + seeds), names=(sequence,)):
            for name in NAMES:
                value = find(name).estimate(one.recording).value
                found.setdefault((name, sequence), []).append(float(axis_deviation(value, one.axes[-1]).max()))
    return found


def main(seeds: int) -> None:
    """Print a line for each estimator."""
    found = errors(seeds)
    print("| | 1 | 2 | 3 | 4 |\n|---|---:|---:|---:|---:|")
    for name in NAMES:
        rows = [np.degrees(found[name, sequence]) for sequence in SEQUENCES]
        print(f"| `{name}` | " + " | ".join(f"{np.median(r):.2f}, {r.max():.2f}" for r in rows) + " |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
