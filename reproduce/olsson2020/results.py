"""What a run gave, in the terms of the paper."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.reproduce.olsson2020 import data, experiments
from imubench.reproduce.olsson2020.settings import (
    BIAS_N_MAX,
    MOTIONS,
    N_MAX,
    SEQUENCES,
    SIZES,
    Settings,
)
from imubench.reproduce.olsson2020.solving import acceptance, sequential_deviations, worst_of_last
from imubench.reproduce.paper import Arrays, Part
from imubench.scenarios.olsson2020.sequences import Section
from imubench.score import axis_deviation

SURFACE = 6  # the motion of figure 2
AUTHORS = (3, 10)  # motions that the authors' own code is run on
BLOCK = 10  # s of a sequence that make one part
PLAIN, WITH_BIAS = "without bias", "with bias"
KINDS = {"clean": PLAIN, "biased": WITH_BIAS}
"""The two rows that table 1 has for each sequence, by the words of the claims' measures."""


@dataclass(frozen=True)
class Runs:
    """Many runs of Algorithms 1 to 4 through one sequence, side by side."""

    deviation: Array  # (t, m, 2) rad
    local: Array  # (t, m, 2) rad, mu_z + 2 sigma_z
    seqad: Array  # (t, m) rad

    def accepted(self, e_max: float, n_min: int) -> NDArray[np.int_]:
        """Return the index of the second (m,) in which Algorithm 4 accepts, -1 for never."""
        return acceptance(self.seqad, self.local, e_max, n_min)

    def errors(self, e_max: float, n_min: int) -> Array:
        """Return the deviations (accepted runs, 2) in rad of the accepted estimates."""
        at = self.accepted(e_max, n_min)
        runs = np.flatnonzero(at >= 0)
        return self.deviation[at[runs], runs]

    def success(self, e_max: float, n_min: int) -> float:
        """Return the part of the accepted estimates that are within `e_max` of the truth; NaN if none was accepted."""
        errors = self.errors(e_max, n_min)
        return float(np.mean((errors <= e_max).all(axis=1))) if len(errors) else float("nan")

    def global_uncertainty(self, n_min: int) -> Array:
        """Return the left side of eq. (68) (t, m) in rad."""
        return worst_of_last(self.seqad, n_min)


@dataclass(frozen=True)
class Results:
    """Everything that was computed."""

    settings: Settings
    surface: Arrays  # figure 2: theta, phi, gyro, accel
    weights: Array  # (w,)
    weighting: dict[int, Array]  # figure 5, by motion: (w, starts, 2) rad
    authors_weights: Array  # (v,) of the next
    authors: dict[int, Array]  # the same by the authors' own code, of two motions; empty where it is not installed
    over_time: dict[str, dict[int, Array]]  # figure 6, by sequence and N_max: (t, 2) rad
    selected: dict[str, Arrays]  # figure 7, by sequence: gyro and accel (t, n_max) sample numbers
    runs: dict[str, Runs]  # figure 8 and section 8.3, by sequence
    table: dict[tuple[str, str], Runs]  # table 1, by sequence and PLAIN or WITH_BIAS
    elsewhere: dict[str, list[Runs]]  # by sequence: other sessions, as section 8.3

    def sections(self, name: str) -> tuple[Section, ...]:
        """Return the pieces of a sequence."""
        return data.sequence(name, self.settings.seed).sections

    def duration(self, name: str) -> float:
        """Return the length of a sequence in s."""
        return self.sections(name)[-1].end

    def times(self, name: str) -> Array:
        """Return when figure 6 has its estimates (t,) in s, at the end of each batch."""
        every, count = self.settings.every, len(self.over_time[name][0])
        return np.arange(1, count + 1, dtype=float) * every

    def rmsae(self, motion: int) -> Array:
        """Return figure 5's curve (w,) in rad."""
        return rmsae_over(self.weighting[motion])


def rmsae_over(deviation: Array) -> Array:
    """Return eq. (71) (w,) in rad of deviations (w, starts, 2) in rad."""
    return np.asarray(np.sqrt(np.mean(deviation**2, axis=(1, 2))))


def parts(s: Settings) -> list[Part]:
    """Return all the work."""
    seed, todo = (
        s.seed,
        [Part("fig2", "figure 2", 0.2, experiments.cost_surface, _arguments(s, number=SURFACE, degrees=s.grid))],
    )
    w0 = experiments.weights(s.weights)
    for number in MOTIONS:
        arguments = _arguments(s, number=number, w0=w0, starts=s.starts)
        todo.append(Part(f"fig5-{number}", "figure 5", s.weights * s.starts * 0.0014, experiments.weighting, arguments))
    if s.authors:
        few = experiments.weights(s.authors_weights)
        for number in AUTHORS:
            arguments = _arguments(s, number=number, w0=few, starts=s.authors_starts)
            work = few.size * s.authors_starts * 0.07
            todo.append(Part(f"authors-{number}", "figure 5", work, experiments.authors_weighting, arguments))
    for name in SEQUENCES:
        seconds = len(data.whole_seconds(data.sequence(name, seed)))
        for size in SIZES:
            work = seconds / s.every * (0.004 if size else 0.01)
            arguments = _arguments(s, name=name, n_max=size, every=s.every)
            todo.append(Part(f"fig6-{name}-{size}", "figure 6", work, experiments.over_time, arguments))
        todo += _runs(s, name, "fig8", N_MAX, seconds) + _runs(s, name, "table1", BIAS_N_MAX, seconds)
        for first in range(0, s.runs, 4):
            last = min(first + 4, s.runs)
            arguments = _arguments(s, name=name, n_max=BIAS_N_MAX, first=first, last=last)
            label = f"table1-bias-{name}-{first}"
            todo.append(Part(label, "table 1, with biases", (last - first) * 1.0, experiments.biased_runs, arguments))
        for other in range(1, s.sessions + 1):
            arguments = _arguments(s, name=name, session=other, count=s.session_runs)
            label = f"other-{name}-{other}"
            todo.append(Part(label, "other sessions", s.session_runs, experiments.other_session, arguments))
    for name in SEQUENCES[:2]:
        todo.append(Part(f"fig7-{name}", "figure 7", 0.7, experiments.selected, _arguments(s, name=name, n_max=N_MAX)))
    return todo


def _arguments(s: Settings, **others: object) -> dict[str, object]:
    return {"seed": s.seed, **others}


def _runs(s: Settings, name: str, label: str, n_max: int, seconds: int) -> list[Part]:
    stage = "figure 8 and section 8.3" if label == "fig8" else "table 1"
    return [
        Part(
            f"{label}-{name}-{first:03d}",
            stage,
            BLOCK * s.runs * 0.0015,
            experiments.runs,
            _arguments(s, name=name, n_max=n_max, first=first, last=min(first + BLOCK, seconds), count=s.runs),
        )
        for first in range(0, seconds, BLOCK)
    ]


def gather(s: Settings, done: Mapping[str, Arrays]) -> Results:
    """Put the parts together."""
    return Results(
        settings=s,
        surface=done["fig2"],
        weights=experiments.weights(s.weights),
        weighting={n: done[f"fig5-{n}"]["deviation"] for n in MOTIONS},
        authors_weights=experiments.weights(s.authors_weights),
        authors={n: done[f"authors-{n}"]["deviation"] for n in AUTHORS if f"authors-{n}" in done},
        over_time={n: {size: done[f"fig6-{n}-{size}"]["deviation"] for size in SIZES} for n in SEQUENCES},
        selected={n: done[f"fig7-{n}"] for n in SEQUENCES[:2]},
        runs={n: _joined(s, done, f"fig8-{n}", n, axis=0) for n in SEQUENCES},
        table={(n, PLAIN): _joined(s, done, f"table1-{n}", n, axis=0) for n in SEQUENCES}
        | {(n, WITH_BIAS): _joined(s, done, f"table1-bias-{n}", n, axis=1) for n in SEQUENCES},
        elsewhere={
            n: [_judged(done[f"other-{n}-{k}"], n, s.seed + k) for k in range(1, s.sessions + 1)] for n in SEQUENCES
        },
    )


def _joined(s: Settings, done: Mapping[str, Arrays], label: str, name: str, axis: int) -> Runs:
    """Return runs from parts that follow each other along an axis: seconds (0) or runs (1)."""
    pieces = sorted((k for k in done if k.rpartition("-")[0] == label), key=lambda k: int(k.rpartition("-")[2]))
    whole = {key: np.concatenate([done[k][key] for k in pieces], axis=axis) for key in ("axes", "local")}
    return _judged(whole, name, s.seed)


def _judged(found: Arrays, name: str, seed: int) -> Runs:
    true = data.sequence(name, seed).axes
    return Runs(axis_deviation(found["axes"], true), found["local"], sequential_deviations(found["axes"]))
