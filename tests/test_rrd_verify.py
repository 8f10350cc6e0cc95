"""Every file that a command writes for Rerun is one that Rerun itself accepts: `rerun rrd verify` says so."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imubench.convert import CONVERTERS
from imubench.diagnosis.result_read import read_diagnosis
from imubench.diagnosis.solve.subset import cut
from imubench.format1 import read, write_recording
from imubench.inputs.toml import load_toml
from imubench.log.run import log_run
from imubench.log.signals import log_sections
from imubench.proof.case import make_case
from tests.command import here
from tests.scenarios import QUICK

ROOT = Path(__file__).resolve().parent.parent
LOGS = {"imubench/log/run.py", "diagnosis/report/rerun_log.py"}
WRITERS = {"imubench/run.py", "diagnosis/on_disk.py"}  # `run` and `estimate`; `diagnose`
ANSWERS = {  # an estimator for the rigs that have one: an axis, a vector, and one that answers sample by sample
    "hinge-hand": "olsson2020",
    "hinge-locked": "olsson2020-plug-and-play",
    "hinge-soft": "seel2012",
    "hinge-walking": "two-imu-centre",
    "pendulum-paper": "arve",
    "pendulum-sliding": "mrvs",
}


def verified(folder: Path) -> list[str]:
    """Return the names of the .rrd files below a folder, after Rerun has read each of them in full."""
    files = sorted(folder.rglob("*.rrd"))
    done = subprocess.run(
        [sys.executable, "-m", "rerun", "rrd", "verify", *map(str, files)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return [str(file.relative_to(folder)) for file in files]


def ran(*words: object) -> None:
    done = here(*words)
    assert done.code == 0, done.err


def diagnosed(folder: Path, *words: object) -> Path:
    """Diagnose `folder`/rec into `folder`/out; a time limit keeps the test short, what is written is the same kind."""
    ran("diagnose", folder / "rec", "--out", folder / "out", *words)
    return folder / "out"


def test_a_file_with_null_in_it_is_refused(tmp_path):
    """What `verified` must see: Rerun's own null for "no state", which its reader does not take (0.41.0)."""
    import pyarrow as pa
    import rerun as rr

    rec = rr.RecordingStream("imubench")
    memory = rec.memory_recording()
    states = rr.StateChange.columns(state=pa.array(["slow", None], pa.string()))
    rec.send_columns("sections/motion", indexes=[rr.TimeColumn("sim_time", duration=[0.0, 1.0])], columns=states)
    (tmp_path / "null.rrd").write_bytes(memory.drain_as_bytes())
    with pytest.raises(AssertionError, match="non-nullable"):
        verified(tmp_path)


def test_sections_with_gaps_and_overlaps(tmp_path):
    import rerun as rr

    for name, sections in {
        "alone": [("a", 1.0, 2.0)],
        "gap": [("a", 1.0, 2.0), ("b", 4.0, 5.0)],
        "overlap": [("a", 1.0, 4.0), ("b", 3.0, 5.0)],
    }.items():
        rec = rr.RecordingStream("imubench")
        memory = rec.memory_recording()
        log_sections(rec, "sections/motion", sections)
        (tmp_path / f"{name}.rrd").write_bytes(memory.drain_as_bytes())
    assert verified(tmp_path) == ["alone.rrd", "gap.rrd", "overlap.rrd"]


@pytest.mark.long
@pytest.mark.parametrize("scenario", QUICK)
def test_run(scenario, tmp_path):
    named = ("--estimator", ANSWERS[scenario]) if scenario in ANSWERS else ()
    ran("run", scenario, *named, "--out", tmp_path / "out")
    assert verified(tmp_path) == ["out/run.rrd"]


@pytest.mark.parametrize("rig", ["hinge", "pendulum", "free"])
def test_a_recording_with_everything_in_it(rig, tmp_path):
    """An encoder, measured poses with holes, free swings, gaps: what `estimate` on real recordings may have to draw."""
    options = {"hinge": {"encoder": True, "pose": True}, "pendulum": {"swing": True}, "free": {}}[rig]
    make_case(tmp_path / "rec", rig, [], 3, seconds=6.0, gaps=2, **options)
    pose = tmp_path / "rec" / "pose1.csv"
    if pose.exists():
        lines = pose.read_text().splitlines()
        lines[10:20] = [re.sub(r",[^,]*", ",", line) for line in lines[10:20]]
        pose.write_text("\n".join(lines) + "\n")
    recording, reference = read(tmp_path / "rec")
    assert rig != "free" or np.isnan(recording.poses[0].position).any()
    log_run(tmp_path / "run.rrd", recording, reference=reference)
    assert verified(tmp_path) == ["run.rrd"]


@pytest.mark.long
def test_estimate(tmp_path):
    make_case(tmp_path / "rec", "hinge", [], 3, seconds=6.0, encoder=True, pose=True)
    ran("estimate", "olsson2020", tmp_path / "rec", "--out", tmp_path / "out")
    assert verified(tmp_path) == ["out/run.rrd"]


@pytest.mark.long
def test_an_estimator_from_outside_that_fails(tmp_path):
    """`run` logs the simulation without an estimate."""
    (tmp_path / "mine.py").write_text("def estimate(recording):\n    raise ValueError('no')\n")
    done = here("run", "hinge-hand", "--estimator", f"{tmp_path}/mine.py:estimate", "--out", tmp_path / "out")
    assert done.code == 1
    assert verified(tmp_path) == ["out/run.rrd"]


@pytest.mark.parametrize("samples", [5, 400], ids=["too few", "one axis mirrored"])
def test_diagnose_what_makes_no_sense(samples, tmp_path):
    """Nothing is fitted: a rig that stands still, the readings in the place of residuals."""
    make_case(tmp_path / "made", "hinge", [], 3, seconds=8.0, rate=50.0)
    recording, reference = read(tmp_path / "made")
    imus = [
        replace(i, time=i.time[:samples], gyro=i.gyro[:samples] * [1, 1, -1], accel=i.accel[:samples] * [1, 1, -1])
        for i in recording.imus
    ]
    write_recording(replace(recording, imus=tuple(imus)), tmp_path / "rec", reference)
    out = diagnosed(tmp_path)
    assert read_diagnosis(out).nonsense
    assert verified(tmp_path) == ["out/diagnosis.rrd"]


@pytest.mark.long
def test_diagnose_estimate_with_it_and_run_its_model(tmp_path):
    make_case(tmp_path / "rec", "hinge", [("time_offset", "imu2", {"offset": 0.04})], 3, seconds=5.0, rate=40.0)
    out = diagnosed(tmp_path, "--time-limit", 12)
    ran("estimate", "olsson2020", tmp_path / "rec", "--with", out, "--out", tmp_path / "with")
    ran("run", out / "model", "--estimator", "olsson2020", "--out", tmp_path / "again")
    assert verified(tmp_path) == ["again/run.rrd", "out/diagnosis.rrd", "with/run.rrd"]


@pytest.mark.long
def test_diagnose_beside_a_baseline(tmp_path):
    for name, seed in (("rec", 3), ("before", 4)):
        make_case(tmp_path / name, "pendulum", [], seed, seconds=8.0, rate=40.0)
    diagnosed(tmp_path, "--baseline", tmp_path / "before", "--time-limit", 16)
    assert verified(tmp_path) == ["out/baseline/diagnosis.rrd", "out/diagnosis.rrd"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("rig", "effect", "options"),
    [
        ("free", ("gyro_bias", "imu1", {"bias": [0.05, -0.05, 0.05]}), {}),
        ("pendulum", ("impacts", "imu1", {"times": [1.5, 3.0, 4.5], "peak": 80.0}), {}),
        ("hinge", ("viscous_friction", "joint", None), {"base": "fixed", "swing": True, "encoder": True}),
    ],
)
def test_diagnose(rig, effect, options, tmp_path):
    make_case(tmp_path / "rec", rig, [effect], 3, "strong", seconds=8.0, rate=40.0, **options)
    out = diagnosed(tmp_path, "--time-limit", 12)
    assert any(w.windows_s for w in read_diagnosis(out).where)  # else nothing is marked in it
    assert verified(tmp_path) == ["out/diagnosis.rrd"]


@pytest.mark.slow
def test_diagnose_foam(recordings, tmp_path):
    """IMUs on foam: misfit at both of them, in many windows."""
    (made,) = CONVERTERS["diodem"](recordings / "diodem" / "trial1", segments="3-4", imu="nonrigid")
    write_recording(cut(made.recording, 20.0, 32.0), tmp_path / "rec")
    diagnosed(tmp_path, "--time-limit", 60)
    assert verified(tmp_path) == ["out/diagnosis.rrd"]


def test_nothing_else_writes_such_files():
    """A new command that logs to Rerun must be added to the tests above."""
    folders = load_toml(ROOT / "pyproject.toml")["tool"]["setuptools"]["package-dir"].values()
    files = {path for folder in folders for path in (ROOT / folder).rglob("*.py")}
    texts = {str(path.relative_to(ROOT)): path.read_text() for path in files}
    assert {name for name, text in texts.items() if "RecordingStream(" in text} == LOGS
    assert {name for name, text in texts.items() if re.search(r"(?<!def )\b(log_run|log_diagnosis)\(", text)} == WRITERS
