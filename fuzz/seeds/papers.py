"""What the reproduction of a paper reads: claims, sequences of motions, finished parts."""

from pathlib import Path

import numpy as np

from fuzz.seeds import laid_out
from imubench.reproduce.parts import Store

PART = "part"
CLAIMS = b"""
[accuracy]
claim = "the axis is found within two degrees"
source = "Table 1"
published = 2.0
unit = "deg"
kind = "at most"
limit = 2.16
basis = "as printed"
measure = "accuracy"
promise = true
guard = 3.0
known = "the printed rounding"

[iterations]
claim = "it takes ten iterations"
source = "Section 4"
published = 10
unit = "iterations"
kind = "about"
limit = 5
basis = "half"
measure = "iterations"
"""
MEASURES = {"accuracy": None, "iterations": None}
SEQUENCES = b"""
[own]
summary = "motions of one's own"
pieces = [1, 2, { motion = 3, half = 1 }, { motion = 5, seconds = [0.0, 4.0], repeat = 2 }]
"""


@laid_out
def parts(folder: Path) -> None:
    """Write a finished part of a paper's work."""
    store = Store(folder / "out", "settings")
    store.save(PART, {"error": np.linspace(0.0, 1.0, 5), "count": np.array(3)})
    store.folder.rename(folder / "kept")  # its name changes with every line of code
    store.home.rmdir()


@laid_out
def claims(folder: Path) -> None:
    """Write the claims of a paper."""
    (folder / "claims.toml").write_bytes(CLAIMS)


@laid_out
def sequences(folder: Path) -> None:
    """Write sequences of motions."""
    (folder / "sequences.toml").write_bytes(SEQUENCES)
