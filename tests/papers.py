"""Two claims, and what stands for a paper's work."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from imubench.reproduce.claims import Claim

BOUNDED = Claim("c", "Errors are small", "section 1", 2.16, "deg", "at most", 2.16, "stated", "m", True)
SEEN = replace(BOUNDED, kind="about", published=90.0, limit=15.0, promise=False)


def counted(n: int, log: str) -> dict[str, np.ndarray]:
    with Path(log).open("a") as file:
        file.write(f"{n}\n")
    return {"square": np.array([n * n])}
