"""The study of soft tissue: its extent, its parts, and what came out."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.estimators import mrvs
from imubench.reproduce.arve import bound
from imubench.reproduce.arve.runs import RATE, noisy, played, removed
from imubench.reproduce.arve.soft_runs import (
    METHODS,
    SETTLED,
    SHAPE,
    UNASSUMED,
    WAYS,
    Cell,
    banked,
    compared,
    distances,
    recorded,
    truth_of,
    unassumed,
)
from imubench.reproduce.paper import Arrays, Part
from imubench.scenarios.pendulum import SoftTissue

AMPLITUDES = (0.005, 0.01, 0.02, 0.03)  # m
FREQUENCIES = (0.3, 0.5, 1.0, 1.5, 3.0, 5.0)  # Hz, of slides
SPRINGS = (2.0, 2.5, 3.0, 3.7, 4.5, 6.0, 9.0, 14.0)  # Hz; 3.7 Hz sags and swings by 20 mm
DAMPINGS = (0.1, 0.2, 0.5)
GYROS = (0.0, 1.0)  # times the sensor's noise
NOISIER = (0.0, 1.0, 3.0, 10.0, 30.0, 100.0)
MID = 0.02  # m, where aims are judged
HUNG = 3.7  # Hz, the spring that moves by that much
BANDS = (0.1, 0.5, 0.8, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0)  # Hz
FINE = np.unique(np.concatenate([np.arange(0.05, 3.0, 0.05), np.arange(0.9, 1.1, 0.01)]))  # Hz
PRIORS = (0.03, 0.003)  # m
SHOWN = {
    "constant": Cell("none"),
    "paper 0.3": Cell("paper", MID, 0.3),
    "paper 1": Cell("paper", MID, 1.0),
    "paper 3": Cell("paper", MID, 3.0),
    "sliding 0.3": Cell("sliding", MID, 0.3),
    "sliding 1": Cell("sliding", MID, 1.0),
    "sliding 3": Cell("sliding", MID, 3.0),
    "sprung 3.7": Cell("sprung", frequency=HUNG),
    "sprung 6": Cell("sprung", frequency=6.0),
}
"""Cases that are also streamed."""
TILTED = ("constant", "sliding 1", "sprung 3.7")


@dataclass(frozen=True)
class Extent:
    """How much is computed."""

    amplitudes: tuple[float, ...]
    frequencies: tuple[float, ...]
    springs: tuple[float, ...]
    dampings: tuple[float, ...]
    phases: int  # over half a turn, each with noise of its own
    seeds: int  # of the cases that are streamed
    shown: tuple[str, ...]  # of these, names of SHOWN
    others: tuple[str, ...]  # names of UNASSUMED
    tilted: tuple[str, ...]  # names of SHOWN
    seed: int

    def turns(self) -> NDArray[np.float64]:
        """Return the phases in rad."""
        return np.pi * np.arange(self.phases) / self.phases


FULL = Extent(AMPLITUDES, FREQUENCIES, SPRINGS, DAMPINGS, 2, 2, tuple(SHOWN), tuple(UNASSUMED), TILTED, 0)
QUICK = Extent(
    (MID,),
    (0.3, 1.0, 3.0),
    (2.5, HUNG),
    (0.2,),
    1,
    1,
    ("constant", "paper 1", "sliding 1", "sprung 3.7"),
    ("band", "uneven spring"),
    ("sliding 1",),
    0,
)


def extent(quick: bool, seed: int) -> Extent:
    """Return the full extent, or a short one."""
    return replace(QUICK if quick else FULL, seed=seed)


@dataclass(frozen=True)
class Soft:
    """Everything that came out; |dr| in m."""

    extent: Extent
    maps: dict[tuple[str, float], Arrays]  # by kind and gyroscope noise; by method (amplitudes, frequencies, phases)
    springs: dict[float, Arrays]  # by gyroscope noise; by method (dampings, springs)
    still: dict[float, Arrays]  # by gyroscope noise, r constant; by method (runs,)
    noisier: Arrays  # MrVS by gyroscope noise, r constant and sliding
    shown: dict[str, Arrays]  # by case; by method (seeds,)
    others: dict[str, Arrays]  # what is not assumed; by method (seeds,)
    gravity: dict[str, Arrays]  # by "case way"; by method (seeds,)
    bounds: Arrays


# --- parts ---


def row(kind: SoftTissue, amplitude: float, gyro: float, e: Extent) -> Arrays:
    """Return one row of a map: by method (frequencies, phases); without gyroscope noise the first phase alone."""
    cells = [
        Cell(kind, amplitude, f, phase, seed=1000 * e.seed + i, gyro_noise=gyro)
        for f in e.frequencies
        for i, phase in enumerate(e.turns() if gyro else e.turns()[:1])
    ]
    return {name: x.reshape(len(e.frequencies), -1) for name, x in distances(cells).items()}


def hanging(gyro: float, damping: float, e: Extent) -> Arrays:
    """Return by method (springs,) at one damping."""
    return distances(
        [Cell("sprung", frequency=f, damping=damping, seed=1000 * e.seed, gyro_noise=gyro) for f in e.springs]
    )


def still(gyro: float, e: Extent) -> Arrays:
    """Return by method (runs,) for a constant r, filters with their covariances for one."""
    return distances([Cell("none", seed=1000 * e.seed + i, gyro_noise=gyro) for i in range(2)], True)


def noisier(e: Extent) -> Arrays:
    """Return mean |dr| (levels,) in m of MrVS by gyroscope noise, r constant, and sliding felt and unfelt at 1 Hz."""
    done: Arrays = {}
    kinds: tuple[SoftTissue, ...] = ("none", "paper", "sliding")
    for kind in kinds:
        found = []
        for level in NOISIER:
            runs = noisy(truth_of(Cell(kind)), 1000 * e.seed + np.arange(10))
            gyro = runs.truth.gyro + level * (runs.gyro - runs.truth.gyro)
            r = mrvs.solve_differenced(gyro, removed(runs, "known"), runs.time)[0]
            found.append(np.linalg.norm(r[:, None] - runs.r, axis=-1).mean())
        done[kind] = np.array(found)
    return done


def shown(name: str, e: Extent) -> Arrays:
    """Return by method (seeds,), batch and stream, of one case of SHOWN; phases by seed."""
    found = []
    for i in range(e.seeds):
        cell = replace(SHOWN[name], phase=np.pi * i / max(e.seeds, 1))
        runs = recorded(truth_of(cell), 1000 * e.seed + i)
        acceleration, late = removed(runs, "known"), round(SETTLED * RATE)
        errors = np.linalg.norm(banked(runs, acceleration) - runs.r, axis=1)
        one = {"bank": np.asarray(errors[late:].mean())}
        found.append(compared(runs, acceleration, name == "constant") | one)
    return _stacked(found)


def other(name: str, e: Extent) -> Arrays:
    """Return by method (seeds,) of one case that is not assumed."""
    found = []
    for i in range(max(1, e.seeds // 2)):
        runs = recorded(unassumed(name, i), 1000 * e.seed + i)
        found.append(compared(runs, removed(runs, "known"), name == "pivot"))
    return _stacked(found)


def tilted(name: str, way: str, e: Extent) -> Arrays:
    """Return by method (seeds,) with gravity taken out by a filter."""
    found = []
    for i in range(max(1, e.seeds // 2)):
        truth = played(False) if name == "constant" else truth_of(SHOWN[name])
        runs = recorded(truth, 1000 * e.seed + i)
        found.append(compared(runs, removed(runs, way), name == "constant"))
    return _stacked(found)


def _stacked(found: list[dict[str, Array]]) -> Arrays:
    return {key: np.array([f[key] for f in found]) for key in found[0]}


def bounds() -> Arrays:
    """Return the Cramer-Rao bounds in m."""
    amplitude = MID * SHAPE
    done = {"only": np.array(bound.only()), "sought": np.array([bound.sought(f, amplitude) for f in FINE])}
    return done | {f"free {p:g}": np.array([bound.free(f, p) for f in BANDS]) for p in PRIORS}


def parts(e: Extent) -> list[Part]:
    """Return all the work."""
    todo = [Part(f"still-{g:g}", "r constant", 4.0, still, {"gyro": g, "e": e}) for g in GYROS]
    for kind in ("paper", "sliding"):
        for g in GYROS:
            for a in e.amplitudes:
                arguments = {"kind": kind, "amplitude": a, "gyro": g, "e": e}
                work = 0.9 * len(e.frequencies) * (e.phases if g else 1)
                todo.append(Part(f"{kind}-{g:g}-{1e3 * a:g}", f"maps, {kind}", work, row, arguments))
    for g in GYROS:
        for z in e.dampings:
            arguments = {"gyro": g, "damping": z, "e": e}
            todo.append(Part(f"sprung-{g:g}-{z:g}", "maps, sprung", 0.9 * len(e.springs), hanging, arguments))
    todo.append(Part("noisier", "gyroscope noise", 3.0, noisier, {"e": e}))
    todo.append(Part("bounds", "Cramer-Rao bounds", 4.0, bounds, {}))
    for name in e.shown:
        todo.append(Part(f"shown-{name}", "streams", 3.5 * e.seeds, shown, {"name": name, "e": e}))
    for name in e.others:
        todo.append(Part(f"other-{name}", "limits", 2.0 * e.seeds, other, {"name": name, "e": e}))
    for name in e.tilted:
        for way in WAYS:
            arguments = {"name": name, "way": way, "e": e}
            todo.append(Part(f"tilted-{name}-{way}", "gravity", 2.0 * e.seeds, tilted, arguments))
    return todo


def gather(e: Extent, done: Mapping[str, Arrays]) -> Soft:
    """Return the results of all parts."""
    names = (*METHODS, "best constant", "kind", "peak")
    maps = {
        (kind, g): {n: np.stack([done[f"{kind}-{g:g}-{1e3 * a:g}"][n] for a in e.amplitudes]) for n in names}
        for kind in ("paper", "sliding")
        for g in GYROS
    }
    springs = {g: {n: np.stack([done[f"sprung-{g:g}-{z:g}"][n] for z in e.dampings]) for n in names} for g in GYROS}
    return Soft(
        e,
        maps,
        springs,
        {g: done[f"still-{g:g}"] for g in GYROS},
        done["noisier"],
        {name: done[f"shown-{name}"] for name in e.shown},
        {name: done[f"other-{name}"] for name in e.others},
        {f"{name} {way}": done[f"tilted-{name}-{way}"] for name in e.tilted for way in WAYS},
        done["bounds"],
    )
