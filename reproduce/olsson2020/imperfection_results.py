"""The work of the imperfection study in parts, and what it gave."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.reproduce.olsson2020 import imperfection_runs as runs
from imubench.reproduce.olsson2020.imperfection_runs import ACCEPTING, SHAPES
from imubench.reproduce.olsson2020.imperfections import IMPERFECTIONS, Imperfection, crossing
from imubench.reproduce.paper import Arrays, Part

CLEAN = "clean rig"
TARGET = 1.5  # deg, the RMSAE that the paper has in all four sequences, give or take 0.1
PAPER_RMSAE = {False: (1.55, 1.58, 1.50, 1.47), True: (1.73, 1.97, 1.58, 1.30)}  # deg, table 1, by added bias
PAPER_MAXAE = {False: (1.67, 2.16, 2.07, 1.98), True: (4.41, 4.84, 3.09, 2.32)}  # deg


@dataclass(frozen=True)
class Extent:
    """How much is computed."""

    seeds: int  # rigs of the sweeps, each with errors in other directions
    slow_seeds: int  # of those that take long
    rigs: int  # of table 1 at the end of the sequences
    runs: int  # M of each
    accepting_rigs: int  # of table 1 by Algorithm 4
    accepting_runs: int  # M of each
    names: tuple[str, ...] = tuple(IMPERFECTIONS)
    every: int = 1  # every how many levels of a sweep one is taken, the last included


THOROUGH = Extent(seeds=4, slow_seeds=2, rigs=4, runs=15, accepting_rigs=4, accepting_runs=4)
FULL = Extent(seeds=3, slow_seeds=2, rigs=2, runs=10, accepting_rigs=2, accepting_runs=4)
QUICK = Extent(1, 0, 1, 2, 0, 0, ("socket tilt", "accel bias", "play under load"), every=5)


@dataclass(frozen=True)
class Swept:
    """The errors over the levels of one imperfection."""

    what: Imperfection
    levels: Array  # (k,)
    deviation: Array  # (seeds, k, 4 sequences, 2 estimates, starts, 2) rad; NaN where a rig could not be played

    @property
    def played(self) -> NDArray[np.bool_]:
        """Which levels (k,) could be played with all seeds, bool."""
        return np.asarray(np.isfinite(self.deviation).all(axis=(0, 2, 3, 4, 5)))

    def at(self, level: float, estimate: int = 0) -> Array:
        """Return RMSAE (4,) in deg at a level, interpolated in the logarithms between those that were played."""
        order = [k for k in np.argsort(self.levels) if self.played[k]]
        if not order:
            return np.full(self.deviation.shape[2], np.nan)
        x, y = np.log(self.levels[order]), np.log(self.rmsae(estimate)[order])
        return np.array([float(np.exp(np.interp(np.log(level), x, column))) for column in y.T])

    def rmsae(self, estimate: int = 0) -> Array:
        """Return RMSAE (k, 4) in deg: of selected samples (0) or all (1)."""
        return np.asarray(np.rad2deg(np.sqrt(np.mean(self.deviation[:, :, :, estimate] ** 2, axis=(0, 3, 4)))))

    def maxae(self, estimate: int = 0) -> Array:
        """Return MAXAE (k, 4) in deg over all rigs, starts and axes."""
        return np.asarray(np.rad2deg(self.deviation[:, :, :, estimate].max(axis=(0, 3, 4))))

    def reaching(self) -> Array:
        """Return the level (4,) at which each sequence's RMSAE with selection reaches TARGET; NaN: not in the sweep."""
        return np.array([crossing(self.levels, column, TARGET) for column in self.rmsae().T])


@dataclass(frozen=True)
class Row:
    """Table 1 of one imperfect rig after another."""

    name: str
    level: float
    biased: bool
    deviation: Array  # (rigs, 4, runs, 2) rad
    seconds: Array | None = None  # (rigs, 4, runs) when Algorithm 4 accepted; None: at the end of the sequence

    def rmsae(self) -> Array:
        """Return RMSAE (rigs, 4) in deg."""
        return np.asarray(np.rad2deg(np.sqrt(np.mean(self.deviation**2, axis=(2, 3)))))

    def maxae(self) -> Array:
        """Return MAXAE (rigs, 4) in deg."""
        return np.asarray(np.rad2deg(self.deviation.max(axis=(2, 3))))


@dataclass(frozen=True)
class Imperfect:
    """Everything the study computed."""

    sweeps: dict[str, Swept]
    at_end: tuple[Row, ...]
    accepted: tuple[Row, ...]


def swept_levels(e: Extent, what: Imperfection) -> tuple[float, ...]:
    """Return the levels that are computed."""
    return tuple(sorted({*what.levels[:: e.every], what.levels[-1]}, key=what.levels.index))


def _seeds(e: Extent, what: Imperfection) -> int:
    """Return how many rigs the sweep of an imperfection has."""
    if what.name not in e.names:
        return 0
    return e.slow_seeds if what.slow else e.seeds


def _shapes(e: Extent) -> dict[str, tuple[str, float]]:
    """Return label -> imperfection and level of the tables; the clean rig is any imperfection at zero."""
    kept = {n: (n, level) for n, level in SHAPES.items() if _seeds(e, IMPERFECTIONS[n])}
    return {CLEAN: ("socket tilt", 0.0)} | kept


def parts(e: Extent) -> list[Part]:
    """Return all the work of the study."""
    todo, stage = [], "imperfections of a real rig"
    for what in IMPERFECTIONS.values():
        levels = swept_levels(e, what)
        for seed in range(_seeds(e, what)):
            work = len(levels) * (0.8 if not what.falling else 6.0)
            arguments = {"name": what.name, "levels": levels, "seed": seed}
            todo.append(Part(f"sweep-{_file(what.name)}-{seed}", stage, work, runs.sweep, arguments))
    for label, (name, level) in _shapes(e).items():
        for seed in range(e.rigs if not IMPERFECTIONS[name].slow else min(e.rigs, e.slow_seeds)):
            for biased in (False, True):
                arguments = {"name": name, "level": level, "seed": seed, "runs": e.runs, "biased": biased}
                part = f"end-{_file(label)}-{seed}-{int(biased)}"
                todo.append(Part(part, stage, e.runs * 0.4 if biased else 1.0, runs.table_at_end, arguments))
                if label in (CLEAN, *ACCEPTING) and seed < e.accepting_rigs:
                    arguments = arguments | {"runs": e.accepting_runs}
                    part = f"accepted-{_file(label)}-{seed}-{int(biased)}"
                    todo.append(Part(part, stage, 8.0, runs.table_when_accepted, arguments))
    return todo


def _file(name: str) -> str:
    return name.replace(" ", "_")


def gather(e: Extent, done: Mapping[str, Arrays]) -> Imperfect:
    """Put the parts together."""
    sweeps = {}
    for name, what in IMPERFECTIONS.items():
        found = [done[f"sweep-{_file(name)}-{seed}"]["deviation"] for seed in range(_seeds(e, what))]
        if found:
            sweeps[name] = Swept(what, np.array(swept_levels(e, what)), np.array(found))
    rows: dict[str, list[Row]] = {"end": [], "accepted": []}
    for label, (_, level) in _shapes(e).items():
        for biased in (False, True):
            for kind, kept in rows.items():
                names = [f"{kind}-{_file(label)}-{seed}-{int(biased)}" for seed in range(e.rigs)]
                rigs = [done[n] for n in names if n in done]
                if rigs:
                    seconds = np.array([rig["seconds"] for rig in rigs]) if kind == "accepted" else None
                    deviation = np.array([rig["deviation"] for rig in rigs])
                    kept.append(Row(label, level, biased, deviation, seconds))
    return Imperfect(sweeps, tuple(rows["end"]), tuple(rows["accepted"]))
