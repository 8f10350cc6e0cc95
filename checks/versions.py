"""What tells one version of an estimator, or of the simulation, from another."""

from functools import lru_cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import imubench
from imubench.inputs.files import read_bytes
from imubench.reproduce.parts import hash_code

SIMULATING = ("imubench.dataset", "imubench.effects", "imubench.models", "imubench.scenarios", "imubench.sim")
"""The packages that decide what a run's recording is."""
ESTIMATING = ("imubench.estimators",)


@lru_cache(2)
def code_key(packages: tuple[str, ...]) -> str:
    """Return what changes with any line of code of some of our packages, and with NumPy's version."""
    digest = sha256(f"{imubench.__version__} {np.__version__}".encode())
    hash_code(digest, packages)
    return digest.hexdigest()[:16]


def estimator_key(estimator: str) -> str:
    """Return what changes with an estimator: with ours, with the files beside its own, or with those of its package.

    What those import from elsewhere is not in it.
    """
    module, colon, _ = estimator.rpartition(":")
    if not colon:
        return f"{estimator} {code_key(ESTIMATING)}"
    folder = Path(module).parent if module.endswith(".py") else _folder(module)
    digest = sha256(estimator.encode())
    for source in sorted(folder.glob("*.py")) if folder is not None else ():
        digest.update(source.name.encode() + read_bytes(source))
    return digest.hexdigest()[:16]


def _folder(module: str) -> Path | None:
    try:
        found = find_spec(module)
    except (ImportError, ValueError):
        found = None
    return None if found is None or found.origin is None else Path(found.origin).parent
