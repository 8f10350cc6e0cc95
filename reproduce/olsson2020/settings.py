"""What is computed, in full and in a hurry; the numbers of sections 7.2 to 7.5."""

import math
from dataclasses import dataclass
from importlib.util import find_spec

DURATIONS = dict.fromkeys(range(1, 15), 47.5) | {1: 65.0, 2: 30.0, 8: 70.0, 9: 60.0}
"""Lengths of the motions in s, read off four remarks in the paper's text: docs/olsson2020-motions.md."""

SEQUENCES = ("sequence1", "sequence2", "sequence3", "sequence4")
MOTIONS = (3, 4, 5, 6, 7, 10, 11, 12, 13, 14)
"""Of figure 5: those in which the joint turns."""

SIZES = (0, 1000, 500, 250, 125)
"""N_max of figure 6; 0 stands for all samples."""

N_MAX, E_MAX, N_MINS = 1000, math.radians(3.0), (3, 10)  # section 7.4
BIAS_N_MAX, BIAS_E_MAX, BIAS_N_MIN = 500, math.radians(1.0), 10  # section 7.5
GYRO_BIAS, ACCEL_BIAS = math.radians(1.0), 1.0  # rad/s, m/s^2
DRAWS = 1000  # L of the Monte Carlo method; the paper gives no value


@dataclass(frozen=True)
class Settings:
    """How much is computed."""

    quick: bool
    seed: int
    runs: int  # M
    weights: int  # values of w0 in figure 5
    starts: int  # for each of them
    every: int  # s between the estimates of figure 6
    grid: float  # deg, of figure 2
    sessions: int  # others than the one of `seed`, beyond the paper
    session_runs: int  # in each of them
    authors: bool  # whether the authors' own code is at hand (the package qmt)
    authors_weights: int  # values of w0 that it is run on
    authors_starts: int


def settings(quick: bool, seed: int) -> Settings:
    """Return the paper's numbers, or fewer runs, weights, starts and estimates of the same."""
    authors = find_spec("qmt") is not None
    if quick:
        return Settings(
            quick, seed, runs=2, weights=14, starts=12, every=5, grid=5.0, sessions=1, session_runs=2,
            authors=authors, authors_weights=5, authors_starts=4,
        )  # fmt: skip
    return Settings(
        quick, seed, runs=100, weights=100, starts=36, every=1, grid=2.0, sessions=8, session_runs=5,
        authors=authors, authors_weights=14, authors_starts=12,
    )  # fmt: skip
