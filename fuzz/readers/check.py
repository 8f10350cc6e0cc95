"""What `imubench check` reads: claims, a baseline, the runs that a stopped check had finished."""

from pathlib import Path

from fuzz.mutate import json, toml
from fuzz.reader import Reader
from fuzz.seeds import checks
from imubench.checks.baseline import read_baselines
from imubench.checks.claim import load_claims
from imubench.checks.pytest_plugin import holds_claims
from imubench.checks.runs import stored_runs


def claimed(f: Path, o: Path) -> object:
    """Read claims about estimators, as pytest does."""
    return holds_claims(f / "claims.toml") and load_claims(f / "claims.toml")


def compared(f: Path, o: Path) -> object:
    """Read a baseline."""
    return read_baselines(f / "baseline.json", load_claims(f / "claims.toml"))


def kept(f: Path, o: Path) -> object:
    """Read finished runs; a damaged file counts as none."""
    return stored_runs(f / "runs.json")


READERS = (
    Reader("check-claims", "claims.toml", checks.claims, toml.mutate, claimed),
    Reader("check-baseline", "baseline.json", checks.baseline, json.mutate, compared),
    Reader("check-runs", "runs.json", checks.runs, json.mutate, kept),
)
