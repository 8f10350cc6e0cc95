"""qmt's estimator and a broken one, from outside by all three ways, beside ours in `run`, `check` and `sweep`."""

import csv
import json
import math
from pathlib import Path

import pytest

from imubench.attempt import attempted
from imubench.checks import runs
from imubench.sweeps import work
from tests.command import here
from tests.test_plugins import imports_as_before, installed, written  # noqa: F401

pytest.importorskip("qmt", reason="needs the extra: pip install 'imubench[peers]'")

THEIRS = '''
    import numpy as np
    import qmt
    from imubench.estimate import Estimate
    from imubench.paired import paired

    def hinge(recording):
        """Return the axes that the package qmt finds."""
        both = paired(recording)
        samples = [np.array(a) for a in (both.accel1, both.accel2, both.gyro1, both.gyro2)]
        axes = np.array([np.ravel(a) for a in qmt.jointAxisEstHingeOlsson(*samples, {"quiet": True})[:2]], dtype=float)
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        return Estimate("joint_axis", "qmt", axes, None, "qmt reports none", pairing="unknown")

    def broken(recording):
        """Raise an error, as an estimator with a mistake does."""
        return np.linalg.cholesky(-np.eye(3))
'''
OURS = "olsson2020"
SCENARIO = "hinge-hand"
RIGHT = math.radians(1.0)
"""Both methods are right to 0.2 deg on 60 s of a hand, and to 0.5 deg on 10 s."""


@pytest.fixture
def ways(tmp_path, monkeypatch):
    """The names of qmt's and of the broken estimator, by a file, by a module and by the entry point of a package."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "theirs.py", THEIRS)
    written(tmp_path / "site" / "their_package" / "hinges.py", THEIRS)
    written(tmp_path / "site" / "their_package" / "__init__.py", "")
    points = "their-qmt = their_package.hinges:hinge\ntheir-broken = their_package.hinges:broken"
    installed(tmp_path / "site", "their-package", points)
    good = ("theirs.py:hinge", "their_package.hinges:hinge", "their-qmt")
    return good, ("theirs.py:broken", "their_package.hinges:broken", "their-broken")


@pytest.mark.long
def test_run(ways):
    """Each scores as ours does; a broken one leaves its line, its trace and the recording."""
    good, broken = ways
    for i, name in enumerate((OURS, *good)):
        done = here("run", SCENARIO, "--duration", "20", "--estimator", name, "--out", f"good-{i}")
        assert done.code == 0, done.err
        score = json.loads(Path(f"good-{i}/score.json").read_text())
        assert score["estimator"] == name
        figures = score["figures"]
        assert (figures.get("maxae") or figures["best_pairing_maxae"])["value"] < RIGHT
    for i, name in enumerate(broken):
        done = here("run", SCENARIO, "--duration", "20", "--estimator", name, "--out", f"broken-{i}")
        assert done.code == 1
        assert f"{name} crashed: LinAlgError" in " ".join(done.out.split())
        assert Path(f"broken-{i}/recording/recording.toml").exists()
        assert "np.linalg.cholesky" in Path(f"broken-{i}/failure.txt").read_text()


@pytest.fixture
def in_this_process(monkeypatch):
    """Attempts without a process of their own, which takes a second to begin; test_attempt.py is about those."""
    monkeypatch.setattr(work, "attempt", lambda method, recording, _: attempted(method, recording))
    monkeypatch.setattr(runs, "attempted", lambda method, recording, *_: attempted(method, recording))


@pytest.mark.long
def test_check(ways, in_this_process):
    """The claim holds of ours and of qmt's by each way, and fails of the broken one, which hinders no other."""
    good, broken = ways
    head = "over = 'median'\nconfidence = 0.9\npower = 0.9\nscenario = 'quick'\n"
    spec = "[scenarios.quick]\nseconds = 10\n[[scenarios.quick.rig]]\nfamily = 'hinge'\n"
    claims = "".join(
        f"[claim.'{name}']\nestimator = '{name}'\nfigure = 'best_pairing_maxae'\nat_most = '1 deg'\n"
        for name in (OURS, *good, *broken)
    )
    Path("claims.toml").write_text(head + spec + claims)
    done = here("check", "claims.toml", "--workers", "1", "--out", "out")
    assert done.code == 1, done.err
    entries = json.loads(Path("out/claims.json").read_text())
    verdicts = {e["name"]: e["verdict"] for e in entries}
    assert verdicts == dict.fromkeys((OURS, *good), "holds") | dict.fromkeys(broken, "fails")
    same = {tuple(e["errors"]) for e in entries if e["name"] in good}
    assert len(same) == 1  # one method, whatever it is called
    assert all("crashed: LinAlgError" in e["why"] for e in entries if e["name"] in broken)


@pytest.mark.long
def test_sweep(ways, in_this_process):
    """A map for each, the same whatever way qmt's comes by; the broken one has no estimate in any cell."""
    good, broken = ways
    rig = "[[rig]]\nfamily = 'hinge'\n"
    axis = "[[axis]]\nparameter = 'effect.gyro_bias.bias.std'\nvalues = [0, 0.02]\n"
    effect = "[[effect]]\nname = 'gyro_bias'\nbias = { std = 0.01 }\n"
    Path("sweep.toml").write_text(f"seconds = 8\nrecordings = 2\nlimit_deg = 2\n{rig}{effect}{axis}")
    names = [word for name in (OURS, *good, *broken) for word in ("--estimator", name)]
    done = here("sweep", "sweep.toml", *names, "--workers", "0", "--out", "out")
    assert done.code == 0, done.err
    with Path("out/sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    by_name = {name: [row["value"] for row in rows if row["estimator"] == name] for name in (OURS, *good, *broken)}
    assert len({tuple(by_name[name]) for name in good}) == 1
    assert all(float(by_name[name][0]) < 2 for name in (OURS, *good))  # deg, without a bias
    assert all(row["crashed"] == row["played"] == "2" for row in rows if row["estimator"] in broken)
    assert all(name in Path("out/report.html").read_text() for name in (OURS, *good, *broken))
