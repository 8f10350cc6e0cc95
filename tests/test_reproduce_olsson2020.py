"""Olsson et al. 2020: Algorithm 4 on many runs side by side, and the quick report."""

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from imubench.estimators.olsson2020 import algorithm1
from imubench.estimators.plug_and_play import uniform_start
from imubench.estimators.uncertainty import Acceptance
from imubench.reproduce import PAPERS
from imubench.reproduce.olsson2020 import data, experiments
from imubench.reproduce.olsson2020.figure7 import density
from imubench.reproduce.olsson2020.settings import E_MAX, settings
from imubench.reproduce.olsson2020.solving import Minima, acceptance, sequential_deviations, worst_of_last
from tests.command import imubench

PAPER = PAPERS["olsson2020"]


def random_runs(seconds: int = 60, runs: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Estimates that jump between two pairs of axes and both signs, and uncertainties around E_max."""
    rng = np.random.default_rng(1)
    pairs = rng.normal(size=(2, 2, 3))
    steps = rng.random((seconds, runs)) < 0.06
    which = np.cumsum(steps, axis=0) % 2
    axes = pairs[which] + rng.normal(scale=0.005, size=(seconds, runs, 2, 3))
    axes *= rng.choice([-1.0, 1.0], size=(seconds, runs, 1, 1)) / np.linalg.norm(axes, axis=-1, keepdims=True)
    return axes, E_MAX * rng.choice([0.5, 1.5], size=(seconds, runs, 2), p=[0.8, 0.2])


@pytest.mark.parametrize("n_min", [1, 3, 10])
def test_runs_side_by_side_are_accepted_as_algorithm_4_accepts_each(n_min):
    axes, local = random_runs()
    seqad = sequential_deviations(axes)
    worst, found = worst_of_last(seqad, n_min), acceptance(seqad, local, E_MAX, n_min)
    for m in range(axes.shape[1]):
        judge_one = Acceptance(E_MAX, n_min)
        verdicts = [judge_one.update(a, u) for a, u in zip(axes[:, m], local[:, m], strict=True)]
        np.testing.assert_array_equal(seqad[:, m], [v.seqad for v in verdicts])
        np.testing.assert_array_equal(worst[:, m], [v.worst_seqad for v in verdicts])
        assert found[m] == next((t for t, v in enumerate(verdicts) if v.accepted), -1)
    assert (found >= 0).any()


def test_starts_that_share_a_minimum_get_what_algorithm_1_gives_them():
    c = data.weighed(data.selections("sequence3", 0, 125)[15])
    rng = np.random.default_rng(2)
    minima = Minima(c, np.random.default_rng(3))
    for _ in range(20):
        start = uniform_start(rng)
        # 1e-6 rad is what counts as one minimum; an answer may then be that far off twice.
        np.testing.assert_allclose(minima.estimate(start)[0], algorithm1(c, start)[0].axes, atol=2e-6)
    assert len(minima._known) < 10


def test_how_the_work_is_cut_changes_nothing():
    whole = experiments.runs(0, "sequence3", 125, 10, 14, 3)
    cut = [experiments.runs(0, "sequence3", 125, a, b, 3) for a, b in ((10, 12), (12, 14))]
    for key in ("axes", "local"):
        np.testing.assert_array_equal(whole[key], np.concatenate([c[key] for c in cut]))
    runs = experiments.biased_runs(0, "sequence3", 125, 0, 2)
    second = experiments.biased_runs(0, "sequence3", 125, 1, 2)
    np.testing.assert_array_equal(runs["axes"][:, 1:], second["axes"])
    assert np.isnan(runs["axes"][-1]).all()  # accepted long before the end, where a run ends


def test_the_grid_holds_both_pairings_alike():
    starts = experiments.grid_starts(36)
    assert len(np.unique(starts.round(9), axis=0)) == 36
    assert len(experiments.grid_starts(12)) == 12


def test_density_counts_held_samples():
    held = np.array([[0, 1, -1], [0, 26, 30]])
    np.testing.assert_allclose(density(held, 60), np.array([[2, 0, 0], [1, 2, 0]]) / 25)  # sums of 1 / 25 round


def test_quick_is_the_same_work_but_less():
    quick, full = PAPER.parts(settings(True, 0)), PAPER.parts(settings(False, 0))
    assert {part.run for part in quick} == {part.run for part in full}
    assert {part.stage for part in quick} == {part.stage for part in full}
    assert sum(part.work for part in quick) < 0.2 * sum(part.work for part in full)
    for parts in (quick, full):
        assert len({part.name for part in parts}) == len(parts)


@pytest.fixture(scope="module")
def quick_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """One quick run that is interrupted on its way and goes on."""
    folder = tmp_path_factory.mktemp("reproduce")
    command = [sys.executable, "-m", "imubench", "reproduce", "olsson2020", "--quick", "--out", "out"]
    first = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for _ in range(600):
        if len(list(folder.glob(".out.parts/*/*.npz"))) > 5:
            break
        time.sleep(0.1)
    first.send_signal(signal.SIGINT)
    _, errors = first.communicate(timeout=60)
    assert first.returncode == 130
    assert "the same command goes on from there" in errors
    assert [p.name for p in folder.iterdir()] == [".out.parts"]
    before = {p.name: p.stat().st_mtime_ns for p in folder.glob(".out.parts/*/*.npz")}
    assert len(before) > 5
    return folder / "out", imubench(*command[3:], folder=folder, limit=300)


@pytest.mark.slow
def test_quick_reproduces_every_figure_and_claim(quick_run):
    out, done = quick_run
    entries = json.loads((out / "claims.json").read_text())
    assert [e["name"] for e in entries] == [claim.name for claim in PAPER.claims]
    assert all(e["why"] for e in entries)
    assert done.returncode == int(any(e["verdict"] == "fails" for e in entries)), done.stderr
    text = (out / "report.html").read_text()
    for name in ("figure2", "figure4", "figure5", "figure6", "figure7", "figure8", "table1", "sessions"):
        assert f"id='{name}'" in text
    assert text.count("data:image/png;base64,") == 6
    assert not re.search(r"(src|href)=.(?!data:|#)", text)
    assert not list(out.parent.glob(".*"))  # parts, partial folders: all gone


@pytest.mark.slow
def test_quick_keeps_the_bounds_that_a_rigid_rig_must_keep(quick_run):
    """Regression: what holds with any seed because the rig is rigid and the method is right."""
    entries = {e["name"]: e for e in json.loads((quick_run[0] / "claims.json").read_text())}
    for name in ("fig5-plateau", "fig5-slow-planar", "fig6-sequence1-1000", "fig6-sequence1-125", "fig7-gyro"):
        assert entries[name]["verdict"] == "holds", entries[name]
    assert entries["accepted-10-sequence3"]["measured"] == 100
