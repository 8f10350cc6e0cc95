"""Specs of sweeps."""

from pathlib import Path

from fuzz.mutate import toml
from fuzz.reader import Reader
from fuzz.readers.dataset import PLAYED
from fuzz.seeds import sweeps
from imubench.dataset.playing import make
from imubench.sweeps.spec import load_sweep


def first_cell(f: Path, o: Path) -> object:
    """Read a sweep and make the first recording of its first cell, where that is short."""
    cell = load_sweep(f / "sweep.toml").cell(0, 0)
    return None if cell.seconds.high * cell.rate > PLAYED else make(cell, 0, 0)


READERS = (Reader("sweep-toml", "sweep.toml", sweeps.sweep, toml.mutate, first_cell),)
