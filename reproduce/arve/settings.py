"""What is computed, in full and in a hurry; the numbers of section IV."""

from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from imubench.reproduce.arve.runs import WAYS

WINDOWS = tuple(range(5, 101, 5))
INITIALS = tuple(range(20, 141, 20))
WINDOW, INITIAL = 45, 60
LIMIT = 0.02  # m, a tenth of |r|: the paper's upper limit
SPHERE = 0.006  # m, of figure 9


@dataclass(frozen=True)
class Settings:
    """How much is computed."""

    quick: bool
    seed: int
    runs: int
    ways: tuple[str, ...]  # of taking gravity out; without VQF where that is not installed

    def seeds(self) -> NDArray[np.int_]:
        """Return one seed of noise a run; never 100, on which the covariances were fitted."""
        return 1000 * self.seed + np.arange(self.runs)


def settings(quick: bool, seed: int) -> Settings:
    """Return the paper's 100 runs, or 10."""
    vqf = find_spec("vqf") is not None
    ways = tuple(way for way in WAYS if vqf or not way.startswith("vqf"))
    return Settings(quick, seed, 10 if quick else 100, ways)
