"""A paper of two claims, and what stands for its work."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from imubench.reproduce.claims import Claim, Measured
from imubench.reproduce.paper import Figure, Paper, Part, Story, Table

BOUNDED = Claim("c", "Errors are small", "section 1", 2.16, "deg", "at most", 2.16, "stated", "m", True)
SEEN = replace(BOUNDED, kind="about", published=90.0, limit=15.0, promise=False)


def imubench(*words: object, folder: Path, limit: float = 300) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "imubench", *map(str, words)]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=limit)


def counted(n: int, log: str) -> dict[str, np.ndarray]:
    with Path(log).open("a") as file:
        file.write(f"{n}\n")
    return {"square": np.array([n * n])}


@contextmanager
def unwatched(parts: list[Part]) -> Iterator[object]:
    yield lambda part: None


def drawn():
    from matplotlib.figure import Figure as Canvas

    canvas = Canvas(figsize=(2, 1))
    canvas.subplots().plot([0, 1], [0, 1])
    return canvas


def small_paper(limit: float) -> Paper:
    claim = replace(BOUNDED, limit=limit, measure="worst", claim="The error is < 2 deg & finite")
    return Paper(
        name="small",
        summary="a paper",
        citation="Somebody, Somewhere",
        claims=(claim, replace(SEEN, name="seen", measure="seen")),
        measures={"worst": lambda r: Measured(r, "of noise"), "seen": lambda r: Measured(r, "the rig is rigid")},
        settings=lambda quick, seed: (quick, seed),
        parts=lambda s: [Part("p", "sum", 1.0, counted, {"n": 1, "log": os.devnull})],
        gather=lambda s, done: float(done["p"]["square"][0]),
        tell=lambda r: Story(
            "Once upon a time",
            (
                Figure("f1", "Figure 1", "It goes up", "A line.", drawn),
                Table("t1", "Table 1", "It is one", "A number.", ("a", "b"), (("1", "2"),)),
            ),
            ("A note",),
        ),
    )
