"""How often a diagnosis speaks where nothing is left out.  python -m benchmarks silence

`python -m benchmarks.silence SEED WORKERS` takes recordings that nobody has seen.

Recordings without an effect by the independent generator: every rig, motion up to 10 Hz, rests, gaps, clocks and rates
of their own, geometry wrong by what is declared; their noise white, coloured (5 to 20 % of its power), declared up to
15 % wrong, or declared half or double. An alarm is a finding of confidence 0.5 or more; that a sensor is twice as
loud as declared is true, and no alarm in the last group.
"""

import os
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.table import Row
from imubench.diagnosis.pipeline import diagnose
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.proof.mixture import RIGS, nuisances
from imubench.trials.detection import wilson

RECORDINGS = 200
SECONDS = 15.0
SEED = 20261121
SAID = 0.5  # confidence from which a finding counts
NOISES = ("gyro_noise", "accel_noise")
MOST = {"white": 0.01, "coloured": 0.03, "declared up to 15 % wrong": 0.03, "declared half or double": 0.03}


@dataclass(frozen=True)
class Silence:
    """One recording without an effect, and what was said of it."""

    seed: int
    noise: str
    rig: str
    options: dict[str, Any]
    said: tuple[str, ...] = ()


def recordings(count: int, seed: int) -> Iterator[Silence]:
    """Yield recordings, a quarter of each kind of noise."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        noise = list(MOST)[i % len(MOST)]
        options = nuisances(rng)
        rig = str(rng.choice(list(RIGS), p=[share for share, _ in RIGS.values()]))
        options |= RIGS[rig][1] | {"seconds": SECONDS, "colour": 0.0, "misdeclared": 0.0, "declare_noise": True}
        if noise == "coloured":
            options["colour"] = float(rng.uniform(0.05, 0.2))
        elif noise == "declared up to 15 % wrong":
            options["misdeclared"] = float(rng.uniform(-0.15, 0.15))
        elif noise == "declared half or double":
            options["misdeclared"] = float(rng.choice([-0.5, 1.0]))
        yield Silence(seed + i, noise, str(options.pop("rig")), options)


def asked(one: Silence) -> Silence:
    """Return the recording with what was said of it."""
    with tempfile.TemporaryDirectory() as scratch:
        make_case(Path(scratch) / "r", one.rig, [], one.seed, **one.options)
        found, _ = diagnose(read(Path(scratch) / "r")[0])
    fine = NOISES if one.noise == "declared half or double" else ()
    said = tuple(f"{f.effect} at {f.at}" for f in found.findings if f.confidence >= SAID and f.effect not in fine)
    return replace(one, said=said)


def run(count: int = RECORDINGS, seed: int = SEED, workers: int | None = None) -> list[Row]:
    """Return a row for each kind of noise; what was said is told as it comes."""
    done = []
    with ProcessPoolExecutor(workers or os.cpu_count()) as pool:
        for one in pool.map(asked, recordings(count, seed)):
            done.append(one)
            said = ", ".join(one.said) or "silent"
            print(f"{len(done)} of {count}: {one.rig}, {one.noise}: {said}", file=sys.stderr, flush=True)
    rows = []
    for noise, most in MOST.items():
        of = [one for one in done if one.noise == noise]
        alarms = sum(bool(one.said) for one in of)
        low, high = wilson(alarms, len(of))
        rows.append(
            Row(
                f"false alarms, recordings of {SECONDS:g} s without an effect, noise {noise}",
                f"{alarms} of {len(of)}, {low:.0%} to {high:.0%}",
                "-",
                "-",
                f"<= {most:.0%}",
                alarms <= most * len(of),
            )
        )
    return rows


if __name__ == "__main__":
    print(*run(seed=int(sys.argv[1]), workers=int(sys.argv[2])), sep="\n")
