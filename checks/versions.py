"""What tells one version of the simulation, or of our estimators, from another."""

from functools import lru_cache
from hashlib import sha256

import numpy as np

import imubench
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
