"""What the reproduction of a paper reads: its claims, its sequences of motions, parts that an earlier run finished."""

from pathlib import Path

from fuzz.mutate import npz, toml
from fuzz.reader import Reader
from fuzz.seeds import papers
from imubench.reproduce.claims import load_claims
from imubench.reproduce.parts import Store
from imubench.scenarios.olsson2020.plan import find


def claimed(f: Path, o: Path) -> object:
    """Read the claims of a paper."""
    return load_claims(f / "claims.toml", papers.MEASURES)


def planned(f: Path, o: Path) -> object:
    """Read a file of one sequence."""
    return find(f / "sequences.toml")


def part(f: Path, o: Path) -> object:
    """Read a finished part of a paper's work."""
    store = Store(f / "out", "settings")
    store.folder = f / "kept"
    return store.load(papers.PART)


READERS = (
    Reader("claims-toml", "claims.toml", papers.claims, toml.mutate, claimed),
    Reader("sequences-toml", "sequences.toml", papers.sequences, toml.mutate, planned),
    Reader("part-npz", "kept/part.npz", papers.parts, npz.mutate, part),
)
