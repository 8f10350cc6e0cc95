"""What a search can find at five times the Cramer-Rao bound.  python -m benchmarks.faint COUNT SEED WORKERS

Recordings of the independent generator, one half without an effect, one half with one at five bounds. Each effect
without states is scored from the fit that knows nothing of it: by the prior that the diagnosis has of its size, and by
one that does not know the size (the mean evidence of `SIZES` times that prior, which a search that wants faint effects
would take). How much the best promises where nothing is says what may be believed: the false alarms that noise of
unknown colour and level leaves are the price of the faint ones. `skin_sliding` is left out: what it promises is not
what it is worth once it is fitted.
"""

import os
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.special import logsumexp

from benchmarks.silence import Silence, recordings
from benchmarks.table import Row
from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.candidates.grids import placed_at_best_start
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.score_test import each, prior_std
from imubench.diagnosis.search.moves.swap_for_term import NAMES
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.schur import Base, promise
from imubench.format1 import read
from imubench.proof.aimed import make_aimed
from imubench.trials.detection import power

COUNT, SEED = 48, 20261126
BOUNDS = 5.0
SIZES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003)  # of the diagnosis' priors
ALARMS = 0.03  # of recordings without an effect
CONCEALED = (
    "gyro_bias", "accel_bias", "gyro_scale", "accel_scale", "gyro_misalignment", "accel_misalignment",
    "g_sensitivity", "gyro_drift", "accel_drift", "mount_shift", "mount_pose",
)  # fmt: skip
REFITTED = "skin_sliding"
SHARED = 0.01  # false alarms of a search over all effects at their places
NUMBERS = (1, 3, 9)  # that an effect has


@dataclass(frozen=True)
class Faint:
    """One recording, the effect in it, and what is promised of each that could be: nat by either prior."""

    made: Silence
    effect: str = ""  # at imu1
    promised: dict[str, tuple[float, float]] | None = None

    @property
    def best(self) -> tuple[float, float]:
        """What the best promises by either prior."""
        said = list((self.promised or {}).values())
        return max(s for s, _ in said), max(s for _, s in said)

    @property
    def truth(self) -> tuple[float, float]:
        """The same of the effect that is there."""
        return (self.promised or {})[f"{self.effect}@imu1"]


def questions(count: int, seed: int) -> Iterator[Faint]:
    """Yield recordings, every other one with an effect; noise white, coloured, or declared up to 15 % wrong."""
    fair = (one for one in recordings(2 * count, seed) if one.noise != "declared half or double")
    for i, one in zip(range(count), fair, strict=False):
        yield Faint(one, CONCEALED[i // 2 % len(CONCEALED)] if i % 2 else "")


def asked(one: Faint) -> Faint:
    """Return a recording with what its effects promise."""
    effects = [(one.effect, "imu1")] if one.effect else []
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch) / "r"
        make_aimed(out, one.made.rig, effects, one.made.seed, [BOUNDS] * len(effects), "medium", **one.made.options)
        fit = begin(read(out)[0]).fit
    base, promised = Base.of(fit), {}
    taken = {h.name for h in fit.model.hypotheses}
    plain, _ = placed_at_best_start(
        base, [h for h in candidates(fit.model) if not h.effect.states and h.name not in taken]
    )
    for h, information, force in each(base, [h for h in plain if h.effect.name != REFITTED]):
        nat = [promise(information, force, s * prior_std(h)).evidence for s in SIZES]
        promised[f"{h.effect.name}@{h.at}"] = (nat[0], float(logsumexp(nat) - np.log(len(SIZES))))
    return replace(one, promised=promised)


def run(count: int = COUNT, seed: int = SEED, workers: int | None = None) -> list[Row]:
    """Return what either prior finds at the level of evidence that the diagnosis asks for, and at equal alarms."""
    done = []
    with ProcessPoolExecutor(workers or os.cpu_count()) as pool:
        for one in pool.map(asked, questions(count, seed)):
            done.append(one)
            name = f"{one.effect}: {one.truth[0]:.1f}, {one.truth[1]:.1f}" if one.effect else "clean"
            best = f"{one.best[0]:.1f}, {one.best[1]:.1f}"
            print(f"{len(done)} of {count}: {one.made.rig}, {one.made.noise}, {name}; best {best}", file=sys.stderr)
    clean = np.array([one.best for one in done if not one.effect])
    faint = np.array([one.truth for one in done if one.effect])
    level = np.quantile(clean, 1 - ALARMS, axis=0)
    rows = []
    for what, least in (
        (f"{EVIDENCE.needed_nat:g} nat", np.array([EVIDENCE.needed_nat, EVIDENCE.needed_nat])),
        (f"what {ALARMS:.0%} of the clean pass ({level[0]:.1f}, {level[1]:.1f} nat)", np.maximum(level, 0.0)),
    ):
        for name, of in (("without an effect, something", clean), (f"with one at {BOUNDS:g} bounds, that one", faint)):
            known, free = (f"{n} of {len(of)}" for n in np.sum(of > least, axis=0))
            rows.append(Row(f"{name} promises {what}: prior of its size; size unknown", known, free, "-", "-", True))
    told = ", ".join(f"{power(BOUNDS, n, SHARED / NAMES):.0%}" for n in NUMBERS)
    what = f"in white noise of a known level, one of {NAMES} that share {SHARED:.0%} of alarms, of {NUMBERS} numbers"
    return [*rows, Row(f"with one at {BOUNDS:g} bounds, a test told which finds it, {what}", told, "-", "-", "-", True)]


if __name__ == "__main__":
    asked_for = [int(x) for x in sys.argv[1:]]
    print(*run(*asked_for), sep="\n")
