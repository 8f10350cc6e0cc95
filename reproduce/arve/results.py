"""What a run gave, in the terms of the paper."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.reproduce.arve import experiments
from imubench.reproduce.arve.experiments import SETUPS
from imubench.reproduce.arve.runs import whole
from imubench.reproduce.arve.settings import INITIAL, INITIALS, LIMIT, Settings
from imubench.reproduce.paper import Arrays, Part, Trial

TRIED = 5
"""Runs of either kind that other estimators are given: runs differ in their noise alone."""
UNITS = np.array([1e3, 1e3, 180 / np.pi])
"""From m, m, rad to what the paper prints: mm, mm, deg."""


@dataclass(frozen=True)
class Results:
    """Everything that was computed; names of arrays are those of experiments.py."""

    settings: Settings
    windows: Arrays
    initials: Array  # (sizes, runs, 3) m, m, rad
    blind: Arrays
    varying: Arrays
    gravity: dict[str, Arrays]  # by way
    setups: dict[str, Arrays]  # by name

    def table(self, method: str) -> Array:
        """Return mean and std (2, 3) of |dr| in mm, d|r| in mm and the angle in deg, over runs and samples."""
        errors = self.varying[method] * UNITS
        return np.stack([errors.mean(axis=(0, 1)), errors.std(axis=(0, 1))])

    def distance(self, way: str, kind: str, method: str) -> float:
        """Return the mean |dr| in mm with gravity taken out in one way, for a `constant` or `varying` r."""
        return float(1e3 * self.gravity[way][f"{kind} {method}"][0])

    def constant(self, size: int = INITIAL) -> Array:
        """Return the mean errors (3,) of ArVE_d in mm, mm and deg, constant r, by how many samples make r0."""
        return np.asarray(self.initials[INITIALS.index(size)].mean(axis=0) * UNITS)

    def settled(self) -> float:
        """Return the s from which on no run that started from zeros is farther than a tenth of |r| from the truth."""
        far = np.flatnonzero((self.blind["distance"] > LIMIT).any(axis=0))
        time = self.blind["time"]
        if far.size == 0:
            return 0.0
        return float(time[far[-1] + 1]) if far[-1] + 1 < time.size else float("inf")


def parts(s: Settings) -> list[Part]:
    """Return all the work."""
    seeds, scale = {"seeds": s.seeds()}, 0.3 + s.runs / 100
    todo = [
        Part("figure4", "figures 4 and 5", 1.4 * scale, experiments.windows, seeds),
        Part("figure6", "figure 6", 1.0 * scale, experiments.initials, seeds),
        Part("figure5", "figures 4 and 5", 0.4 * scale, experiments.blind, seeds),
        Part("table1", "table I, figures 7 to 9", 0.9 * scale, experiments.varying, seeds),
    ]
    for way in s.ways:
        todo.append(Part(f"gravity-{way}", "gravity removal", scale, experiments.gravity, seeds | {"way": way}))
    for name in SETUPS:
        todo.append(Part(f"setup-{name}", "other readings", 2 * scale, experiments.setup, seeds | {"name": name}))
    return todo


def trials(s: Settings) -> list[Trial]:
    """Return runs with a constant and with a varying r, for any estimator."""
    kinds = {"r constant": False, "r varying": True}
    return [
        Trial(f"{kind}, seed {seed}", whole, {"varying": varying, "seed": int(seed)})
        for kind, varying in kinds.items()
        for seed in s.seeds()[:TRIED]
    ]


def gather(s: Settings, done: Mapping[str, Arrays]) -> Results:
    """Return the results of all parts."""
    return Results(
        s,
        done["figure4"],
        done["figure6"]["errors"],
        done["figure5"],
        done["table1"],
        {way: done[f"gravity-{way}"] for way in s.ways},
        {name: done[f"setup-{name}"] for name in SETUPS},
    )
