"""Estimators beside a paper's own method, on the paper's recordings."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from imubench.attempt import attempted
from imubench.errors import InputError
from imubench.reproduce import PAPERS, beside
from imubench.reproduce.arve.runs import whole as run_of_the_pendulum
from imubench.reproduce.olsson2020 import data
from imubench.reproduce.paper import Trial
from imubench.run import simulate
from imubench.score import axis_deviation
from tests.command import here
from tests.test_plugins import imports_as_before, installed, written  # noqa: F401
from tests.test_reproduce import small_paper

THEIRS = """
    import numpy as np

    def y(recording):
        return np.tile([0.0, 1.0, 0.0], (2, 1))

    y.quantity = "joint_axis"

    def broken(recording):
        raise ValueError("no")

    def centre(recording):
        return np.zeros((2, 3))

    centre.quantity = "joint_vector"

    def hanging(recording):
        while True:
            pass

    def nan(recording):
        return np.full((2, 3), np.nan)

    nan.quantity = "joint_axis"
"""


@pytest.fixture
def small(monkeypatch, tmp_path):
    """A paper whose recordings are two simulated hinges; estimators by a file and an entry point; one process."""
    trials = (
        Trial("one", simulate, {"scenario": "hinge-hand", "seed": 1}),
        Trial("two", simulate, {"scenario": "hinge-planar"}),
    )
    paper = replace(small_paper(2.0), method="seel2012", trials=lambda s: trials)
    monkeypatch.setitem(PAPERS, "small", paper)
    monkeypatch.setattr("imubench.reproduce.reproduce.cores", lambda: 0)
    monkeypatch.setattr(beside, "attempted", lambda method, recording, *_: attempted(method, recording))
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "theirs.py", THEIRS)
    written(tmp_path / "site" / "their_axes.py", THEIRS)
    installed(tmp_path / "site", "their-axes", "their-broken = their_axes:broken")
    return paper


def test_each_is_in_the_report_and_in_beside_json_and_the_claims_are_the_papers(small, tmp_path):
    words = ("--estimator", "theirs.py:y", "--estimator", "their-broken", "--out", "out")
    done = here("reproduce", "small", *words)
    assert done.code == 0, done.err
    said = " ".join(done.out.split())
    assert "Median error on 2 recordings: seel2012 0.0" in said
    assert "their-broken no answer" in said
    entries = json.loads((tmp_path / "out" / "beside.json").read_text())
    errors = {(e["recording"], e["estimator"]): e["error"] for e in entries}
    assert set(errors) == {(t, e) for t in ("one", "two") for e in ("seel2012", "theirs.py:y", "their-broken")}
    assert errors["one", "seel2012"] < math.radians(0.5) < errors["one", "theirs.py:y"]  # any axis is far off
    assert {e["why"] for e in entries if e["estimator"] == "their-broken"} == {
        "crashed: ValueError: no (their_axes.py, line 10)"
    }
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Other estimators" in page and "theirs.py:y" in page and "crashed" in page
    alone = here("reproduce", "small", "--out", "alone")
    assert "Median error" not in alone.out
    assert not (tmp_path / "alone" / "beside.json").exists()
    assert (tmp_path / "alone" / "claims.json").read_bytes() == (tmp_path / "out" / "claims.json").read_bytes()


@pytest.mark.long
def test_one_that_hangs_or_answers_nan_is_told_in_its_place(small, monkeypatch, tmp_path):
    """Each in a process of its own, which is ended; the others have their errors all the same."""
    monkeypatch.setattr(beside, "attempted", attempted)
    names = ("theirs.py:hanging", "theirs.py:nan", "theirs.py:y")
    words = [word for name in names for word in ("--estimator", name)]
    done = here("reproduce", "small", *words, "--time-limit", "5", "--out", "out")
    assert done.code == 0, done.err
    entries = json.loads((tmp_path / "out" / "beside.json").read_text())
    why = {e["estimator"]: e["why"].partition(":")[0] for e in entries}
    assert why == {"seel2012": "", "theirs.py:hanging": "timed out", "theirs.py:nan": "malformed", "theirs.py:y": ""}
    page = (tmp_path / "out" / "report.html").read_text()
    assert page.count("<td class='number'>timed out</td>") == page.count("<td class='number'>malformed</td>") == 2


def test_what_cannot_stand_beside_a_paper_is_one_line(small):
    for paper, name, message in (
        (
            "olsson2020-beyond",
            "seel2012",
            "expected a paper whose recordings others can be given, got olsson",
        ),
        ("small", "theirs.py:centre", "--estimator theirs.py:centre: expected one of the joint_axis, as small is"),
        ("small", "nobody", "unknown estimator 'nobody'"),
    ):
        with pytest.raises(InputError, match=message):
            beside.asked_for(PAPERS[paper], None, [name])


def test_the_trials_of_arve_are_its_runs():
    """The same samples as its experiments have, with a truth that scores them."""
    recording, truth = run_of_the_pendulum(varying=True, seed=3)
    asked = beside.asked_for(PAPERS["arve"], PAPERS["arve"].settings(True, 0), ["mrvs"])
    assert [t.name for t in asked.trials][:2] == ["r constant, seed 0", "r constant, seed 1"]
    assert len(asked.trials) == 10
    np.testing.assert_array_equal(recording.imus[0].time, truth.time)
    found = beside.estimated(run_of_the_pendulum, {"varying": False, "seed": 3}, "mrvs", "mrvs", "ours", "error", 60.0)
    assert found["error"] < 0.02  # m: a tenth of |r|, the paper's limit


@pytest.mark.long
def test_the_trials_of_olsson_are_its_motions_and_sequences():
    paper = PAPERS["olsson2020"]
    asked = beside.asked_for(paper, paper.settings(True, 0), ["seel2012"])
    assert asked.trials[0].name == "motion 3" and asked.trials[-1].name == "sequence4"
    recording, truth = data.whole("motion 11", 0)
    samples = data.motion(11, 0)
    np.testing.assert_array_equal(recording.imus[0].gyro, samples.gyro1)
    axes = np.stack([s.joint_axis.mean(axis=0) for s in truth.sensors])
    assert axis_deviation(axes, data.session(0).axes).max() < 1e-6  # the rig is rigid
