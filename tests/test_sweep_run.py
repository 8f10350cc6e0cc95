"""A sweep goes on whatever its cells and its estimators do, and comes to the same bytes whoever makes it."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from imubench.attempt import attempted
from imubench.errors import InputError
from imubench.sweeps import load_sweep, sweep
from imubench.sweeps import work as sweep_work
from tests.command import here

SWEEP = """
name = "small"
seconds = 3
recordings = 3
limit_deg = 2
[[rig]]
family = "hinge"
mount_distance = 0.1
segment_length = 0.3
[[effect]]
name = "rocking_mount"
at = "imu2"
damping_ratio = 0.1
com = 0.003
[[axis]]
parameter = "effect.rocking_mount.frequency"
values = [0.6, 12, 30]
"""  # 0.6 Hz does not hold the sensor
MINE = """
import time
import numpy as np

def at_random(recording):
    axes = np.random.default_rng(len(recording.imus[0].time)).standard_normal((2, 3))
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)

def crashes(recording):
    raise ValueError(f"no {object()}")

def nan(recording):
    return np.full((2, 3), np.nan)

def one_row(recording):
    return np.eye(3)[:1]

def hangs(recording):
    while True:
        time.sleep(0.1)

def slow(recording):
    time.sleep(0.2)
    return at_random(recording)

for function in (at_random, crashes, nan, one_row, hangs, slow):
    function.quantity = "joint_axis"
"""


@pytest.fixture(autouse=True)
def files(tmp_path, monkeypatch):
    (tmp_path / "sweep.toml").write_text(SWEEP)
    (tmp_path / "mine.py").write_text(MINE)
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def in_this_process(monkeypatch):
    """Attempts without a process of their own, which takes a second to begin."""
    monkeypatch.setattr(sweep_work, "attempt", lambda method, recording, _: attempted(method, recording))


def contents(folder: Path) -> dict[str, bytes]:
    """Every file but the note of sizes and times."""
    files = (p for p in sorted(folder.rglob("*")) if p.is_file() and p.name != ".imubench.json")
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in files}


def test_what_cannot_be_played_and_who_fails_is_shown_so_and_the_run_goes_on(tmp_path, in_this_process):
    names = ["seel2012", "mine.py:crashes", "mine.py:nan", "mine.py:one_row"]
    cells = sweep(load_sweep(Path("sweep.toml")), names, Path("out"), workers=0)
    by = {(c.at[0], c.estimator): c for c in cells}
    assert [by[(i, "seel2012")].played for i in range(3)] == [0, 3, 3]
    assert by[(2, "seel2012")].value < by[(1, "seel2012")].value < 90  # deg; a stiffer mount rocks less
    assert by[(1, "mine.py:crashes")].outcomes == {"crashed": 3}
    assert by[(1, "mine.py:crashes")].value == np.inf
    assert by[(1, "mine.py:nan")].outcomes == by[(1, "mine.py:one_row")].outcomes == {"malformed": 3}
    with Path("out/sweep.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 12
    assert {r["effect.rocking_mount.frequency"] for r in rows} == {"0.6", "12", "30"}
    assert [r["value"] for r in rows if r["estimator"] == "mine.py:nan"] == ["", "inf", "inf"]
    assert [r["failed"] for r in rows if r["estimator"] == "mine.py:nan"] == ["0", "3", "3"]
    table = pq.read_table("out/recordings.parquet").to_pylist()
    assert len(table) == 3 * 3 * 4
    assert {r["outcome"] for r in table if r["effect.rocking_mount.frequency"] == 0.6} == {"not played"}
    assert "springs that hold the sensor" in next(r["why"] for r in table if r["outcome"] == "not played")
    page = Path("out/report.html").read_text()
    assert "3 of 9 recordings, in 1 of 3 cells, cannot be played" in page
    assert "mine.py:crashes: crashed on 6 recordings" in page
    assert "0x..." in page  # of an object in memory: no address, which is another one in every run
    assert str(tmp_path) not in page
    told = json.loads(Path("out/sweep.json").read_text())
    assert told["findings"]["seel2012"].startswith("seel2012: the median of the error")
    assert {e["estimator"] for e in told["estimators"]} == set(names)


def test_a_run_that_was_stopped_goes_on_to_the_same_bytes(in_this_process):
    asked, names = load_sweep(Path("sweep.toml")), ["seel2012", "mine.py:at_random"]
    sweep(asked, names, Path("whole"), workers=0)

    def stop(what: str, done: int, total: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(asked, names, Path("stopped"), workers=0, report=stop)
    kept = list(Path(".stopped.parts").rglob("*.npz"))
    assert len(kept) == 1  # one recording of the row of three cells
    assert not Path("stopped").exists()
    kept[0].write_bytes(kept[0].read_bytes()[:100])  # damaged: made again
    told = []
    sweep(asked, names, Path("stopped"), workers=0, report=lambda what, done, total: told.append((done, total)))
    assert told[0] == (0, 9)
    assert contents(Path("stopped")) == contents(Path("whole"))
    assert not Path(".stopped.parts").exists()


def test_another_estimator_of_the_same_name_is_another_sweep(in_this_process):
    asked, seen = load_sweep(Path("sweep.toml")), []

    def stop(what: str, done: int, total: int) -> None:
        seen.append(done)
        if done == 3:
            raise KeyboardInterrupt

    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            sweep(asked, ["mine.py:at_random"], Path("out"), workers=0, report=stop)
        Path("mine.py").write_text(MINE + "\n# changed\n")
    assert seen == [0, 3, 0, 3]  # what the older one had done counts for nothing


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["seel2012", "nobody"], "unknown estimator 'nobody'"),
        (
            ["seel2012", "hinge-position"],
            "estimators of one quantity, got joint_axis of seel2012, joint_vector of",
        ),
        (["hinge-position"], "limit: expected limit_mm for the error of a joint_vector, got limit_deg"),
        ([], "--estimator: expected one or more, got none"),
    ],
)
def test_estimators_that_do_not_go_together_are_refused(names, said):
    with pytest.raises(InputError, match=said):
        sweep(load_sweep(Path("sweep.toml")), names, Path("out"), workers=0)
    assert not Path("out").exists()


def test_a_figure_that_a_score_has_not_is_refused():
    Path("sweep.toml").write_text(SWEEP.replace("limit_deg", "figure = 'error'\nlimit_deg"))
    with pytest.raises(InputError, match=r"unknown figure of a joint_axis 'error'; known: rmsae, maxae, deviation"):
        sweep(load_sweep(Path("sweep.toml")), ["seel2012"], Path("out"), workers=0)


def test_joint_centres_in_millimetres_and_the_largest_of_the_imus(in_this_process):
    Path("sweep.toml").write_text(SWEEP.replace("limit_deg", "limit_mm").replace("[0.6, 12, 30]", "[12, 30]"))
    (cell, *_) = sweep(load_sweep(Path("sweep.toml"), 1), ["hinge-position"], Path("out"), workers=0)
    assert 0 < cell.value < 1000  # mm, of a rig of 30 cm
    assert pq.read_table("out/sweep.parquet")["unit"][0].as_py() == "mm"


@pytest.mark.long
def test_the_command_with_a_hang_in_it():
    done = here(
        "sweep", "sweep.toml", "--estimator", "mine.py:hangs", "--estimator", "seel2012",
        "--recordings", 1, "--time-limit", 0.5, "--workers", 0, "--out", "out",
    )  # fmt: skip
    assert done.code == 0, done.err
    assert "mine.py:hangs: the median of the error is below 2 deg in no cell" in done.out
    table = pq.read_table("out/recordings.parquet").to_pylist()
    assert [r["outcome"] for r in table if r["estimator"] == "mine.py:hangs"] == [
        "not played",
        "timed out",
        "timed out",
    ]


def started(out: str) -> subprocess.Popen:
    words = ["sweep", "sweep.toml", "--estimator", "mine.py:slow", "--workers", "2", "--out", out]
    return subprocess.Popen([sys.executable, "-m", "imubench", *words], start_new_session=True)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="kills with SIGKILL")
def test_killed_in_the_middle_it_goes_on_to_the_same_bytes():
    assert started("whole").wait(300) == 0
    run, end = started("killed"), time.monotonic() + 200
    while not list(Path(".killed.parts").rglob("*.npz")):
        assert run.poll() is None and time.monotonic() < end, "it did not come to a finished piece"
        time.sleep(0.01)
    os.kill(run.pid, signal.SIGKILL)
    assert run.wait(30) == -signal.SIGKILL
    assert not Path("killed").exists()
    assert started("killed").wait(300) == 0
    assert contents(Path("killed")) == contents(Path("whole"))
    assert not Path(".killed.parts").exists()


@pytest.mark.slow
def test_ray_makes_the_same_bytes():
    pytest.importorskip("ray")
    asked, names = load_sweep(Path("sweep.toml"), 1), ["seel2012", "mine.py:at_random"]
    sweep(asked, names, Path("here"), workers=0)
    sweep(asked, names, Path("there"), workers=1, engine="ray")
    assert contents(Path("there")) == contents(Path("here"))
