"""The commands that write, each as short as it gets, with what they read and what they may leave behind."""

import csv
import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from imubench.dataset.generate import generate
from imubench.dataset.shard import Job
from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Interval, Parameter
from imubench.diagnosis.result_file import as_dict
from imubench.proof.case import make_case
from imubench.reproduce import PAPERS
from imubench.reproduce.claims import Claim, Measured
from imubench.reproduce.paper import Figure, Paper, Part, Story

SPEC = """
name = "small"
seconds = 10
recordings_per_rig = 2
recordings_per_file = 2
[[rig]]
family = "hinge"
[[motion]]
kind = "random"
"""
SWEEP = (
    SPEC.replace("recordings_per_file = 2", "recordings = 1\nlimit_deg = 2")
    + """
[[axis]]
parameter = "motion.bandwidth"
values = [1, 2]
[[axis]]
parameter = "rig.mount_distance"
values = [0.05, 0.1]
"""
)
SILENT = """
import json, pathlib, sys
out = pathlib.Path(sys.argv[2])
out.mkdir()
pair = {"before": {}, "after": {}, "unit": ""}
(out / "diagnosis.json").write_text(json.dumps({"format": 1, "recording": "recording", "rig": "hinge",
  "verdict": "no mismatch", "misfit": {"nominal": 1.0, "explained": 1.0, "unit": ""}, "where": [], "findings": [],
  "rejected": [], "fit": {"heldout": {"before": 1.0, "after": 1.0}, "left_out_channel": pair, "reference": pair},
  "model": "", "seconds": 0.1}))
"""
CLAIMS = """
estimator = "seel2012"
scenario = "quick"
confidence = 0.9
power = 0.9
[scenarios.quick]
seconds = 4
[[scenarios.quick.rig]]
family = "hinge"
[claim.axis]
figure = "best_pairing_rmsae"
at_most = "5 deg"
over = "median"
"""
TRUTH = {"documented": "screwed on", "effects": [], "may": []}


@dataclass(frozen=True)
class Command:
    """A command line that writes `out` in the folder it is given in; `{given}` in it is what `given` made."""

    name: str
    words: str
    last: tuple[str, ...] = ()  # words with spaces in them
    writes: tuple[str, ...] = ("out",)  # the files and folders that it makes
    copied: tuple[str, ...] = ()  # of `{given}`, to the folder it is given in
    kept: tuple[str, ...] = ()  # patterns of what may be left to go on with
    replaces: bool = True  # a finished folder of another command
    prelude: str = ""  # module:function to be called first
    modules: tuple[str, ...] = ()  # what it imports that is slow to import

    def line(self, given: Path) -> list[str]:
        """Return the words."""
        return [word.replace("{given}", str(given)) for word in (*self.words.split(), *self.last)]


CASES = "prove --cases 1 --seed 5 --seconds 6 --workers 1 --out out --diagnosis"
OF_A_PROGRAM = ("{given}/silent.py {recording} {out}",)
COMMANDS = {
    c.name: c
    for c in (
        Command("list", "list --out out"),
        Command("run", "run hinge-hand --estimator seel2012 --out out"),
        Command("estimate", "estimate seel2012 {given}/recording --out out"),
        Command("estimate --with", "estimate mrvs {given}/pendulum --with {given}/diagnosis --out out"),
        Command("convert csv", "convert csv {given}/table.csv --option rig=free --out out"),
        Command("convert parquet", "convert csv {given}/table.csv --option rig=free --table parquet --out out"),
        Command("diagnose", "diagnose {given}/pendulum --out out"),
        Command(
            "reproduce",
            "reproduce tiny --quick --out out",
            kept=(".out.parts",),
            prelude="tests.faults.commands:tiny",
        ),
        Command(
            "generate",
            "generate {given}/spec.toml --count 3 --seed 3 --workers 0 --out out",
            kept=("out",),
            replaces=False,
        ),
        Command(
            "generate, 2 workers",
            "generate {given}/spec.toml --count 3 --seed 3 --workers 2 --out out",
            kept=("out",),
            replaces=False,
        ),
        Command(
            "sweep",
            "sweep {given}/sweep.toml --estimator seel2012 --workers 0 --out out",
            kept=(".out.parts",),
        ),
        Command("check", "check {given}/claims.toml --workers 1 --out out", kept=(".out.runs",)),
        Command("check, 2 workers", "check {given}/claims.toml --workers 2 --runs 60 --out out", kept=(".out.runs",)),
        Command("export qmt", "export qmt {given}/dataset --out out"),
        Command("export opensim", "export opensim {given}/dataset --count 1 --out out"),
        Command("export ring", "export ring {given}/dataset --out out"),
        Command("prove", CASES, OF_A_PROGRAM, kept=(".out.trials",)),
        Command(
            "prove --seal",
            "prove --seal lab/monday.truth.json",
            writes=("lab/monday.commitment.json", "lab/monday.sealed.json"),
            copied=("lab",),
            replaces=False,
        ),
    )
}
"""By what is short for their line."""


def given(folder: Path) -> Path:
    """Make what the commands read, and return its folder."""
    folder.mkdir(parents=True)
    make_case(folder / "recording", "hinge", [], 5, seconds=4.0)
    make_case(folder / "pendulum", "pendulum", [], 5, seconds=3.0)
    (folder / "diagnosis").mkdir()
    (folder / "diagnosis" / "diagnosis.json").write_text(json.dumps(as_dict(_diagnosis())))
    with (folder / "table.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time", "gyr_x", "gyr_y", "gyr_z", "acc_x", "acc_y", "acc_z"])
        samples = np.random.default_rng(0).normal([0, 0, 0, 0, 0, 9.81], 0.1, size=(2000, 6))
        writer.writerows([n / 100, *row] for n, row in enumerate(samples.tolist()))
    (folder / "spec.toml").write_text(SPEC)
    (folder / "sweep.toml").write_text(SWEEP)
    generate(Job({"spec.toml": SPEC.encode()}, 3, 3, str(folder / "dataset")), workers=0)
    (folder / "claims.toml").write_text(CLAIMS)
    (folder / "silent.py").write_text(SILENT)
    (folder / "lab").mkdir()
    shutil.copytree(folder / "recording", folder / "lab" / "monday")
    (folder / "lab" / "monday.truth.json").write_text(json.dumps(TRUTH))
    return folder


def _diagnosis() -> Diagnosis:
    bias = Parameter((0.1, 0.0, 0.0), (0.01, 0.01, 0.01), "m/s^2")
    found = Finding("accel_bias", "imu1", 0.95, {"bias": bias}, Interval(10.0, (5.0, 15.0)))
    return Diagnosis(
        "recording", "pendulum", "explained", (2.0, 1.0), (), (found,), (), FitQuality((2.0, 1.0)), "", 1.0
    )


def square(n: int) -> dict[str, np.ndarray]:
    """Return the work of a part, larger than what is written at a time."""
    return {"square": np.full(20_000, n * n)}


def tiny() -> None:
    """Add a paper that takes no time."""
    claim = Claim("c", "It is small", "section 1", 2.0, "deg", "at most", 2.0, "stated", "m", True)
    PAPERS["tiny"] = Paper(
        name="tiny",
        summary="a paper",
        citation="Somebody, Somewhere",
        claims=(claim,),
        measures={"m": lambda r: Measured(r, "of noise")},
        settings=lambda quick, seed: (quick, seed),
        parts=lambda s: [Part(f"p{n}", "sum", 1.0, square, {"n": n}) for n in range(2)],
        gather=lambda s, done: float(done["p1"]["square"][0]),
        tell=lambda r: Story("Once", (Figure("f1", "Figure 1", "It goes up", "A line.", _drawn),)),
    )


def _drawn():
    from matplotlib.figure import Figure as Canvas

    canvas = Canvas(figsize=(2, 1))
    canvas.subplots().plot([0, 1], [0, 1])
    return canvas
